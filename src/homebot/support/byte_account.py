"""The byte account: a limit on the memory of all clients of a server together. Pure."""

from collections.abc import Callable, Iterable
from typing import Generic, TypeVar, final

Client = TypeVar("Client")


@final
class ByteAccount(Generic[Client]):
    """The bytes held for all clients; above the limit, the client with the most loses some.

    Args:
        clients: Returns the clients, oldest first: of equal ones the oldest loses.
        size_of: Returns the current bytes of a client.
        shed: Drops some of a client's bytes, or the client, and subtracts them with :meth:`add`; returns True if more
            will be dropped later although nothing was yet.

    Attributes:
        used: The current bytes.
        on_overrun: Called when they exceed the limit; by default :meth:`relieve`.
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
        """Add *size* bytes, which may be negative."""
        self.used += size
        if self.used > self._most and size > 0 and not self._is_relieving:
            self.on_overrun()

    def relieve(self, has_time: Callable[[], bool] = lambda: True) -> bool:
        """Drop bytes of the largest clients until the limit is met; return False if there was no time."""
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
