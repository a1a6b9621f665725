"""What is to be done later, by whom the clock does not belong to. Pure."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable
from typing import TypeAlias

__all__ = ["Callback", "TimerQueue"]

Callback: TypeAlias = Callable[[], None]

_SLACK = 64
"""Outdated entries that may lie in the heap beside the valid ones before it is built anew."""


class TimerQueue:
    """Deeds by name, each at a time; the earliest comes first, of equal times the one planned first.

    Args:
        max_deeds: How many may be planned at once.
    """

    def __init__(self, max_deeds: int = 100_000) -> None:
        self._max_deeds = max_deeds
        self._heap: list[tuple[float, int, Hashable]] = []
        self._planned: dict[Hashable, tuple[int, Callback]] = {}
        self._number = 0

    def plan(self, name: Hashable, at: float, deed: Callback) -> bool:
        """Plan *deed* for *at*, in place of what was planned under *name*; False when there is no room for another."""
        if name not in self._planned and len(self._planned) >= self._max_deeds:
            return False
        self._number += 1
        self._planned[name] = self._number, deed
        heapq.heappush(self._heap, (at, self._number, name))
        if len(self._heap) > 2 * len(self._planned) + _SLACK:
            self._heap = [entry for entry in self._heap if self._is_valid(entry)]
            heapq.heapify(self._heap)
        return True

    def drop(self, name: Hashable) -> None:
        """Plan nothing under *name* any more."""
        self._planned.pop(name, None)

    def next(self) -> float | None:
        """Return when the next deed is due; None for never."""
        while self._heap and not self._is_valid(self._heap[0]):
            heapq.heappop(self._heap)
        return self._heap[0][0] if self._heap else None

    def pop(self, now: float) -> Callback | None:
        """Return the next deed that is due at *now*, and plan it no more; None when there is none."""
        at = self.next()
        if at is None or at > now:
            return None
        _, _, name = heapq.heappop(self._heap)
        return self._planned.pop(name)[1]

    def __contains__(self, name: Hashable) -> bool:
        return name in self._planned

    def __len__(self) -> int:
        return len(self._planned)

    def _is_valid(self, entry: tuple[float, int, Hashable]) -> bool:
        planned = self._planned.get(entry[2])
        return planned is not None and planned[0] == entry[1]
