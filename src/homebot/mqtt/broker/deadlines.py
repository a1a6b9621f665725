"""Things to do at a later time, without a timer of their own: whoever owns the clock asks what is due."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable
from typing import final

__all__ = ["BrokerTimers", "Deadline"]


@final
class Deadline:
    """One thing to do at one time."""

    __slots__ = ("action", "when")

    def __init__(self, when: float, action: Callable[[], None]) -> None:
        self.when = when
        self.action: Callable[[], None] | None = action

    def cancel(self) -> None:
        """Do not do it; harmless afterwards."""
        self.action = None

    def __lt__(self, other: Deadline) -> bool:
        return self.when < other.when


@final
class BrokerTimers:
    """A heap of deadlines.

    Args:
        wake: Told the time of the earliest deadline whenever it moves forward.
    """

    def __init__(self, wake: Callable[[float], None] | None = None) -> None:
        self.wake = wake
        self._heap: list[Deadline] = []
        self._sweep_at = 64

    @property
    def earliest(self) -> float | None:
        """Time of the next deadline, on the clock's monotonic scale, or None."""
        while self._heap and self._heap[0].action is None:
            heapq.heappop(self._heap)
        return self._heap[0].when if self._heap else None

    def at(self, when: float, action: Callable[[], None]) -> Deadline:
        """Have *action* called once *when* has come."""
        deadline = Deadline(when, action)
        if len(self._heap) >= self._sweep_at:  # cancelled ones must not pile up
            self._heap = [each for each in self._heap if each.action is not None]
            heapq.heapify(self._heap)
            self._sweep_at = max(64, 2 * len(self._heap))
        heapq.heappush(self._heap, deadline)
        if self.wake is not None and self._heap[0] is deadline:
            self.wake(when)
        return deadline

    def run(self, now: float) -> None:
        """Do everything due at *now*, in order of time; what is noted meanwhile has to wait for the next run."""
        if not self._heap or self._heap[0].when > now:
            return
        due: deque[Deadline] = deque()
        while self._heap and self._heap[0].when <= now:
            due.append(heapq.heappop(self._heap))
        try:
            while due:
                action = due.popleft().action
                if action is not None:
                    action()
        finally:
            for left in due:
                heapq.heappush(self._heap, left)
