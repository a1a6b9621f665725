"""Bytes that wait for the sockets of clients, over all of them."""

from __future__ import annotations

from typing import Protocol, final

__all__ = ["SlowSocket", "UnsentBytes"]


class SlowSocket(Protocol):
    """A socket that takes bytes slower than they come."""

    @property
    def unsent(self) -> int:
        """The bytes that wait for it now."""
        ...

    def give_up(self) -> None:
        """Cut it."""
        ...


@final
class UnsentBytes:
    """The bytes that wait for sockets; beyond the bound, the one for which most wait is cut.

    Args:
        max_bytes: The bound.
    """

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._waiting: dict[SlowSocket, int] = {}
        self.size = 0

    def note(self, socket: SlowSocket, size: int) -> None:
        """So many bytes wait for *socket* now; 0 where it has caught up or gone."""
        self.size += size - self._waiting.pop(socket, 0)
        if size:
            self._waiting[socket] = size
        if self.size > self._max_bytes:
            self._waiting = {each: each.unsent for each in self._waiting}
            self.size = sum(self._waiting.values())
            while self.size > self._max_bytes:
                largest = max(self._waiting, key=self._waiting.__getitem__)
                self.size -= self._waiting.pop(largest)
                largest.give_up()
