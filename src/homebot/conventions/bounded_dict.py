"""A dictionary of limited size, with pinned values. Pure."""

from collections.abc import Callable, Iterator
from typing import Generic, TypeVar

T = TypeVar("T")


class BoundedDict(Generic[T]):
    """Values by name. In a full one, a new value replaces the oldest that is not pinned.

    Args:
        room: The most values.
        forget: Called with each dropped value.

    Attributes:
        dropped: Number of dropped and refused values.
    """

    def __init__(self, room: int, forget: Callable[[T], object] | None = None) -> None:
        self.dropped = 0
        self._room = room
        self._forget = forget
        self._unpinned: dict[str, T] = {}
        self._pinned: dict[str, T] = {}

    def get(self, name: str) -> T | None:
        """Return the value of *name*."""
        value = self._pinned.get(name)
        return self._unpinned.get(name) if value is None else value

    def find(self, name: str, make: Callable[[], T]) -> T | None:
        """Return the value of *name*, made if there is none; None if there is no room for it."""
        value = self.get(name)
        if value is None:
            value = make()
            return value if self.add(name, value) else None
        return value

    def add(self, name: str, value: T) -> bool:
        """Add *value*; return False if all values are pinned."""
        if len(self) >= self._room:
            self.dropped += 1
            if not self._unpinned:
                return False
            oldest = self._unpinned.pop(next(iter(self._unpinned)))
            if self._forget is not None:
                self._forget(oldest)
        self._unpinned[name] = value
        return True

    def pin(self, name: str) -> None:
        """Retain the value of *name*: it is never dropped."""
        if name in self._unpinned:
            self._pinned[name] = self._unpinned.pop(name)

    def remove(self, name: str) -> T | None:
        """Remove and return the value of *name*, or None."""
        value = self._pinned.pop(name, None)
        return self._unpinned.pop(name, None) if value is None else value

    def items(self) -> Iterator[tuple[str, T]]:
        """Yield the values with their names, those that are not pinned first."""
        yield from self._unpinned.items()
        yield from self._pinned.items()

    def __len__(self) -> int:
        return len(self._unpinned) + len(self._pinned)
