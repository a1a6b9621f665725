"""A queue of due times. Pure: callers pass the time."""

import heapq
import math
from typing import Generic, TypeAlias, TypeVar, final

Key = TypeVar("Key")
Item = TypeVar("Item")

_Entry: TypeAlias = tuple[float, int, Key, Item]

_SLACK = 64
"""Outdated entries allowed in the heap, in addition to the number of valid ones, before it is rebuilt."""


@final
class TimerQueue(Generic[Key, Item]):
    """A time and an item for each key; the earliest comes first, of equal times the one set first.

    Setting a later time, as every sign of life does, only costs a look-up: the heap keeps the earlier time, and the key
    is reinserted when that comes.

    Attributes:
        earliest: A time before which nothing is due: the last result of :meth:`next`, or an earlier time set since.
    """

    def __init__(self) -> None:
        self._entries: dict[Key, _Entry[Key, Item]] = {}
        self._queued: dict[Key, float] = {}  # the valid time in the heap of each key
        self._heap: list[_Entry[Key, Item]] = []
        self._number = 0
        self.earliest = math.inf

    def set(self, key: Key, at: float, item: Item) -> None:
        """Schedule *item* for the time *at*, or never if that is infinite, replacing the earlier item of *key*."""
        self._number = number = self._number + 1
        entry = self._entries[key] = (at, number, key, item)
        if at < self._queued.get(key, math.inf):
            self._queued[key] = at
            heapq.heappush(self._heap, entry)
            if at < self.earliest:
                self.earliest = at
            if len(self._heap) > 2 * len(self._entries) + _SLACK:
                self._rebuild()

    def discard(self, key: Key) -> None:
        """Remove *key*. Idempotent."""
        if self._entries.pop(key, None) is not None:
            self._queued.pop(key, None)  # an infinite time is not in the heap
            if len(self._heap) > 2 * len(self._entries) + _SLACK:
                self._rebuild()

    def time_of(self, key: Key) -> float | None:
        """Return when *key* is due; None if it is unknown."""
        entry = self._entries.get(key)
        return None if entry is None else entry[0]

    def next(self) -> float | None:
        """Return the earliest time; None if there is none."""
        heap = self._heap
        while heap:
            first = heap[0]
            entry = self._entries.get(first[2])
            if entry is first:
                self.earliest = first[0]
                return first[0]
            if entry is None or self._queued.get(first[2]) != first[0]:
                heapq.heappop(heap)
            elif entry[0] == math.inf:
                del self._queued[heapq.heappop(heap)[2]]
            else:
                self._queued[first[2]] = entry[0]
                heapq.heapreplace(heap, entry)
        self.earliest = math.inf
        return None

    def pop(self, now: float = math.inf) -> tuple[Key, Item] | None:
        """Remove and return the earliest key with its item; None if nothing is due at *now*."""
        earliest = self.next()
        if earliest is None or earliest > now:
            return None
        _, _, key, item = heapq.heappop(self._heap)
        del self._entries[key], self._queued[key]
        return key, item

    def __contains__(self, key: Key) -> bool:
        return key in self._entries

    def __len__(self) -> int:
        return len(self._entries)

    def _rebuild(self) -> None:
        self._heap = [entry for entry in self._entries.values() if entry[0] < math.inf]
        self._queued = {key: at for at, _, key, _ in self._heap}
        heapq.heapify(self._heap)
