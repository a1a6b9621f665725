"""What is to be done when: a queue in time order, in which ties go by who came first."""

from __future__ import annotations

import heapq
from collections.abc import Callable

__all__ = ["EventQueue"]

SLACK = 64
"""Entries called off that are no work worth a sweep; they are swept once they are more than these and half of all."""


class EventQueue:
    """Things to do, by time. The number that breaks ties is the same in every run, so the order is too."""

    def __init__(self) -> None:
        self._entries: list[tuple[float, int, str, Callable[[], None]]] = []
        self._planned: dict[str, tuple[float, int]] = {}
        self._called_off: set[int] = set()
        self._number = 0

    def __len__(self) -> int:
        """How many entries it keeps, those called off included."""
        return len(self._entries)

    def add(self, at: float, action: Callable[[], None]) -> None:
        """Do *action* at *at*."""
        self._push(at, "", action)

    def plan(self, who: str, at: float | None, action: Callable[[], None]) -> None:
        """Do *action* at *at*, in place of what was planned for *who* (not empty); None calls it off."""
        planned = self._planned.get(who)
        if planned is not None:
            if planned[0] == at:
                return
            self._called_off.add(planned[1])
            del self._planned[who]
            self._sweep()
        if at is not None:
            self._push(at, who, action)
            self._planned[who] = (at, self._number)

    def next_at(self) -> float | None:
        """Return when the next thing is to be done, or None."""
        while self._entries and self._entries[0][1] in self._called_off:
            self._called_off.discard(heapq.heappop(self._entries)[1])
        return self._entries[0][0] if self._entries else None

    def pop(self) -> Callable[[], None]:
        """Take the next thing off; :meth:`next_at` must have said that there is one."""
        _, _, who, action = heapq.heappop(self._entries)
        self._planned.pop(who, None)
        return action

    def _push(self, at: float, who: str, action: Callable[[], None]) -> None:
        self._number += 1
        heapq.heappush(self._entries, (at, self._number, who, action))

    def _sweep(self) -> None:
        if len(self._called_off) > SLACK + len(self._entries) // 2:
            self._entries = [entry for entry in self._entries if entry[1] not in self._called_off]
            heapq.heapify(self._entries)
            self._called_off.clear()
