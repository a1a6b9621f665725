"""Time limits of waits that nearly always end earlier, with one timer of the event loop for all."""

import asyncio
import heapq
import math
from collections.abc import Callable
from contextvars import Context
from typing import Final, final

_SLACK: Final = 64
"""Discarded limits allowed in the heap, in addition to the number of valid ones, before it is rebuilt."""


@final
class TimeLimits:
    """Callbacks for waits that take too long, in the event loop's time. Not for use from several event loops.

    A loop timer per wait would cost more than a short wait: it is a heap entry that is compared in Python, and stays
    when cancelled. A ``TimerQueue`` would keep discarded entries for a while, here a command and everything it refers
    to.
    """

    def __init__(self) -> None:
        self._ends: dict[int, Callable[[], object]] = {}
        self._heap: list[tuple[float, int]] = []  # including discarded numbers, but not their callbacks
        self._room = _SLACK
        self._number = 0
        self._rings_at = math.inf
        self._timer: asyncio.TimerHandle | None = None

    def set(self, seconds: float, end: Callable[[], object]) -> int:
        """Call *end* after so many seconds; return a number for :meth:`discard`."""
        self._number = number = self._number + 1
        at = asyncio.get_running_loop().time() + seconds
        self._ends[number] = end
        heapq.heappush(self._heap, (at, number))
        if len(self._heap) > self._room:
            self._heap[:] = [entry for entry in self._heap if entry[1] in self._ends]
            heapq.heapify(self._heap)
            self._room = 2 * len(self._heap) + _SLACK
        if at < self._rings_at:
            self._ring_at(at)
        return number

    def discard(self, number: int) -> None:
        """Remove the limit with that number. Idempotent."""
        self._ends.pop(number, None)

    def _ring_at(self, at: float) -> None:
        if self._timer is not None:
            self._timer.cancel()
        self._rings_at = at
        self._timer = asyncio.get_running_loop().call_at(at, self._ring, context=Context())

    def _ring(self) -> None:
        heap, ends, now = self._heap, self._ends, asyncio.get_running_loop().time()  # timers may fire slightly early
        self._rings_at, self._timer = math.inf, None
        try:
            while heap and (heap[0][0] <= now or heap[0][1] not in ends):
                end = ends.pop(heapq.heappop(heap)[1], None)
                if end is not None:
                    end()
        finally:
            if heap and heap[0][0] < self._rings_at:
                self._ring_at(heap[0][0])
