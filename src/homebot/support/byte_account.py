"""Byte account: how much memory all clients of a server may hold together. Pure."""

from collections.abc import Callable, Iterable
from typing import Generic, TypeVar, final

__all__ = ["ByteAccount"]

Client = TypeVar("Client")


@final
class ByteAccount(Generic[Client]):
    """The bytes that all clients hold together; above the bound, the client with the most loses some.

    Args:
        clients: Returns the clients, the oldest first: of equal ones it loses first.
        size_of: Returns the bytes of a client now.
        shed: Drops some of a client's bytes, or the client, and subtracts them with :meth:`add`; returns True if the
            client may lose more although it has lost none yet.

    Attributes:
        used: The bytes now.
        on_overrun: Called when they exceed the bound; by default :meth:`relieve`.
    """

    __slots__ = ("_clients", "_is_relieving", "_most", "_shed", "_size_of", "on_overrun", "used")

    def __init__(
        self,
        most: int,
        clients: Callable[[], Iterable[Client]],
        size_of: Callable[[Client], int],
        shed: Callable[[Client], object],
    ) -> None:
        self.used = 0
        self.on_overrun: Callable[[], object] = self.relieve
        self._most = most
        self._clients = clients
        self._size_of = size_of
        self._shed = shed
        self._is_relieving = False

    def add(self, size: int) -> None:
        """Count *size* more bytes, or fewer if it is negative."""
        self.used += size
        if self.used > self._most and size > 0 and not self._is_relieving:
            self.on_overrun()

    def relieve(self, has_time: Callable[[], bool] = lambda: True) -> bool:
        """Drop bytes of the largest client, again and again, until the bound is kept; False if there was no time."""
        if self.used <= self._most:
            return True
        self._is_relieving = True
        try:
            sizes = {client: self._size_of(client) for client in self._clients()}
            while self.used > self._most and any(sizes.values()):
                if not has_time():
                    return False
                largest = max(sizes, key=sizes.__getitem__)
                may_lose_more = self._shed(largest)
                left = self._size_of(largest)
                sizes[largest] = left if may_lose_more or left < sizes[largest] else 0
        finally:
            self._is_relieving = False
        return True
