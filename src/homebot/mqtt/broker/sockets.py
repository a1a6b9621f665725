"""All sockets of one broker: how many there may be, and waiting until they are gone."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Protocol, final

import anyio

from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import ReasonCode

__all__ = ["OpenSocket", "Sockets"]

_READ_AT_MOST = 16 * 1024  # handled in one turn of the loop: some hundred messages, then it is the others' turn
_PER_CLIENT = 2  # those not logged in must not keep the others out, nor be without bound


class OpenSocket(Protocol):
    """A connection as those see it who count it."""

    @property
    def address(self) -> str:
        """The far side."""
        ...

    def end(self, reason: ReasonCode) -> None:
        """Close it in order; MQTT 5 clients are told *reason*, and no will is published."""
        ...

    def abort(self) -> None:
        """Cut it without a word."""
        ...


@final
class Sockets:
    """The open sockets; those that only wait for their end make room for new ones.

    Attributes:
        read_buffer: Where bytes arrive, one place for all: they are taken before the next socket is read.
    """

    def __init__(self) -> None:
        self.read_buffer = memoryview(bytearray(_READ_AT_MOST))
        self._open: dict[OpenSocket, None] = {}
        self._ending: dict[OpenSocket, None] = {}  # the oldest first
        self._empty: anyio.Event | None = None

    def __len__(self) -> int:
        return len(self._open)

    def __iter__(self) -> Iterator[OpenSocket]:
        return iter(list(self._open))

    def admit(self, socket: OpenSocket, hub: BrokerState) -> bool:
        """Count *socket*; False where there are too many, and it has to be cut."""
        if len(self._open) >= _PER_CLIENT * hub.limits.max_connections and not self._end_one():
            hub.warn(
                "broker.too_many_sockets",
                f"the broker turned {socket.address} away: {len(self._open)} connections are open already",
                address=socket.address,
                sockets=len(self._open),
            )
            hub.counters.connections_refused += 1
            return False
        hub.counters.connections_accepted += 1
        self._open[socket] = None
        return True

    def ends(self, socket: OpenSocket) -> None:
        """*socket* is only kept so that its client can read why it was closed."""
        if socket in self._open:
            self._ending[socket] = None

    def lost(self, socket: OpenSocket) -> None:
        """*socket* is closed."""
        self._open.pop(socket, None)
        self._ending.pop(socket, None)
        if self._empty is not None and not self._open:
            self._empty.set()

    async def wait_until_gone(self) -> None:
        """Wait until all are closed."""
        while self._open:
            self._empty = anyio.Event()
            await self._empty.wait()

    def _end_one(self) -> bool:
        oldest = next(iter(self._ending), None)
        if oldest is None:
            return False
        del self._ending[oldest]
        self._open.pop(oldest, None)
        oldest.abort()
        return True
