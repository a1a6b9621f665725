"""Arrivals at the door: connections without a session, and bytes that are not handled yet."""

from asyncio import Transport
from collections.abc import Iterator
from typing import Final, Protocol, final

from homebot.support.byte_account import ByteAccount

_MAX_ARRIVING: Final = 64
"""Most connections without a session; one more closes the oldest."""

_MAX_OF_ONE: Final = 131_072
"""Most bytes of a connection without a session: of a request to the HTTP API, and of a page that must log in."""


class Arrival(Protocol):
    """A connection."""

    transport: Transport

    def cut_off(self, problem: str) -> None:
        """Close it at once because of *problem*."""
        ...


@final
class Arrivals:
    """The connections without a session, oldest first, and the bytes of all that are not handled yet.

    Args:
        most: Most bytes of all connections together; above it, the one with the most is cut off.
    """

    def __init__(self, most: int) -> None:
        self._without_session: dict[Arrival, None] = {}
        self._bytes: dict[Arrival, int] = {}
        self._account = ByteAccount(most, lambda: self._bytes, lambda one: self._bytes.get(one, 0), self._cut)

    def __iter__(self) -> Iterator[Arrival]:
        return iter(tuple(self._without_session))

    def add(self, connection: Arrival) -> None:
        """Add a connection without a session."""
        self._bytes.setdefault(connection, 0)
        self._without_session[connection] = None
        if len(self._without_session) > _MAX_ARRIVING:
            self._cut(next(iter(self._without_session)))

    def has_session(self, connection: Arrival) -> None:
        """Record that *connection* has a session, or is being answered."""
        self._without_session.pop(connection, None)

    def hold(self, connection: Arrival, size: int) -> None:
        """Count *size* more bytes of *connection*, or fewer if negative."""
        if connection in self._bytes:
            self._bytes[connection] += size
            self._account.add(size)
            if connection in self._without_session and self._bytes[connection] > _MAX_OF_ONE:
                self._cut(connection)

    def remove(self, connection: Arrival) -> None:
        """Remove a connection that has ended."""
        self._without_session.pop(connection, None)
        self._account.add(-self._bytes.pop(connection, 0))

    def _cut(self, connection: Arrival) -> None:
        self.remove(connection)
        connection.cut_off("too many bytes of clients are incomplete or not handled")
