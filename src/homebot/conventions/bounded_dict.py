"""A dictionary with room for so many values, of which some are kept for good. Pure."""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

__all__ = ["BoundedDict"]

T = TypeVar("T")


class BoundedDict(Generic[T]):
    """Values by name. A new one for which there is no room takes the place of the oldest that is not kept for good.

    Args:
        room: How many there may be.
        forget: Called with what was dropped.

    Attributes:
        dropped: How many were dropped or not taken, so far.
    """

    def __init__(self, room: int, forget: Callable[[T], None] | None = None) -> None:
        self.dropped = 0
        self._room = room
        self._forget = forget
        self._passing: dict[str, T] = {}
        self._kept: dict[str, T] = {}

    def get(self, name: str) -> T | None:
        """Return what is called *name*."""
        found = self._kept.get(name)
        return self._passing.get(name) if found is None else found

    def add(self, name: str, value: T) -> bool:
        """Add *value*; False where all room is taken for good."""
        if len(self) >= self._room:
            self.dropped += 1
            if not self._passing:
                return False
            oldest = self._passing.pop(next(iter(self._passing)))
            if self._forget is not None:
                self._forget(oldest)
        self._passing[name] = value
        return True

    def pin(self, name: str) -> None:
        """Keep what is called *name* for good."""
        if name in self._passing:
            self._kept[name] = self._passing.pop(name)

    def remove(self, name: str) -> T | None:
        """Remove and return what is called *name*; None where nothing is."""
        found = self._kept.pop(name, None)
        return self._passing.pop(name, None) if found is None else found

    def __len__(self) -> int:
        return len(self._passing) + len(self._kept)
