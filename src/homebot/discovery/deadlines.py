"""When each of many things is due, and which is next. Pure."""

from __future__ import annotations

import heapq
import math
from typing import final

__all__ = ["Deadlines"]

_SLACK = 64


@final
class Deadlines:
    """One deadline for each key. Moving one later, as every sign of life does, costs no more than a look-up.

    The heap holds, for each key, a time not after its deadline; a key that turns up too early goes back in. What was
    overtaken stays in the heap until it turns up, or until it is more than half of the heap.
    """

    def __init__(self) -> None:
        self._deadlines: dict[str, float] = {}
        self._queued: dict[str, float] = {}
        self._heap: list[tuple[float, str]] = []

    def set(self, key: str, deadline: float) -> None:
        """Make *deadline* the one of *key*."""
        self._deadlines[key] = deadline
        if deadline < self._queued.get(key, math.inf):
            self._queue(key, deadline)
            self._tidy()

    def discard(self, key: str) -> None:
        """Forget *key*; one that is not there is fine."""
        if self._deadlines.pop(key, None) is not None:
            del self._queued[key]
            self._tidy()

    def next(self) -> float | None:
        """Return the earliest deadline, or None when there is none."""
        while self._heap:
            queued, key = self._heap[0]
            if self._queued.get(key) != queued:
                heapq.heappop(self._heap)
            elif (deadline := self._deadlines[key]) > queued:
                self._queued[key] = deadline
                heapq.heapreplace(self._heap, (deadline, key))
            else:
                return deadline
        return None

    def pop(self, now: float) -> str | None:
        """Forget the key with the earliest deadline and return it, or None when it is later than *now*."""
        earliest = self.next()
        if earliest is None or earliest > now:
            return None
        _, key = heapq.heappop(self._heap)
        del self._deadlines[key], self._queued[key]
        return key

    def _queue(self, key: str, deadline: float) -> None:
        self._queued[key] = deadline
        heapq.heappush(self._heap, (deadline, key))

    def _tidy(self) -> None:
        if len(self._heap) > 2 * len(self._deadlines) + _SLACK:
            self._queued = dict(self._deadlines)
            self._heap = [(deadline, key) for key, deadline in self._deadlines.items()]
            heapq.heapify(self._heap)
