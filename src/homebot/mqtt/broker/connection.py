"""The sockets of clients: writes of one loop turn are joined, and closing does not lose the reason."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable, Iterator
from typing import Final, cast, final

import anyio

from homebot.mqtt.broker.peer import Peer
from homebot.mqtt.broker.ports import ConnectionHandler, Transport
from homebot.mqtt.broker.state import BrokerState
from homebot.mqtt.packets import ReasonCode
from homebot.support.byte_account import ByteAccount

_MAX_READ_BYTES = 16 * 1024
_PER_CLIENT = 2  # logins must not keep others out, but need a bound


@final
class Sockets:
    """The open sockets; those that are being closed make room for new ones.

    Attributes:
        unsent: The bytes waiting for all sockets.
        read_buffer: The buffer for incoming bytes, shared because it is emptied before the next socket is read.
    """

    def __init__(self, max_unsent: int) -> None:
        self.read_buffer = memoryview(bytearray(_MAX_READ_BYTES))
        self._open: dict[BrokerConnection, None] = {}
        self.unsent = ByteAccount(max_unsent, self._open.keys, BrokerConnection.count_unsent, BrokerConnection.cut_slow)
        self._ending: dict[BrokerConnection, None] = {}  # the oldest first
        self._empty: anyio.Event | None = None

    def __len__(self) -> int:
        return len(self._open)

    def __iter__(self) -> Iterator[BrokerConnection]:
        return iter(list(self._open))

    def admit(self, socket: BrokerConnection, state: BrokerState) -> bool:
        """Count *socket*; False if there are too many and it has to be cut."""
        if len(self._open) >= _PER_CLIENT * state.limits.max_connections and not self._end_one():
            state.warn(
                "broker.too_many_sockets",
                f"the broker refused {socket.address}: {len(self._open)} connections are already open",
                address=socket.address,
                sockets=len(self._open),
            )
            state.counters.connections_refused += 1
            return False
        state.counters.connections_accepted += 1
        self._open[socket] = None
        return True

    def ends(self, socket: BrokerConnection) -> None:
        """Record that *socket* only stays open so that its client can read the reason for closing."""
        if socket in self._open:
            self._ending[socket] = None

    def lost(self, socket: BrokerConnection) -> None:
        """Remove the closed *socket*."""
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


_WORTH_COUNTING = 16 * 1024  # bytes waiting for one socket
_MAX_JOINED_BYTES = 128 * 1024  # larger data is written at once, so that the transport's limit applies
_TCP_QUICKACK: Final[int | None] = getattr(socket, "TCP_QUICKACK", None)  # only on Linux


@final
class BrokerConnection(asyncio.BufferedProtocol):
    """A connection between an asyncio transport and a :class:`Peer`; a :class:`Transport`."""

    def __init__(
        self,
        state: BrokerState,
        loop: asyncio.AbstractEventLoop,
        sockets: Sockets,
        endpoint: Callable[[BrokerState, Transport], ConnectionHandler] = Peer,
    ) -> None:
        self.write_blocked = False
        self.address = "?"
        self.peer = endpoint(state, self)
        self._state = state
        self._loop = loop
        self._sockets = sockets
        self._buffer = sockets.read_buffer
        self._transport: asyncio.Transport | None = None
        self._tcp: socket.socket | None = None
        self._out: list[bytes] = []
        self._out_size = 0
        self._closing = False
        self._large = 0  # bytes of a message that fills the buffer alone
        self._counted = 0  # bytes, as counted in those of all sockets
        self._lingering: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Set up the open socket."""
        self._transport = transport = cast("asyncio.Transport", transport)
        address = transport.get_extra_info("peername")
        if isinstance(address, tuple):
            self.address = f"{address[0]}:{address[1]}"
        if self._closing or not self._sockets.admit(self, self._state):
            self.abort()
            return
        self._limit_writing(0)
        sock = transport.get_extra_info("socket")
        if sock is not None and sock.family in (socket.AF_INET, socket.AF_INET6):
            sock.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._tcp = sock

    def get_buffer(self, sizehint: int) -> memoryview:  # noqa: ARG002 - asyncio's signature
        """Return the buffer for the next bytes, which all connections share."""
        return self._buffer

    def buffer_updated(self, nbytes: int) -> None:
        """Handle received bytes; an error of homebot's only costs this connection."""
        self._state.receive(self.peer, bytes(self._buffer[:nbytes]), self.address)
        if nbytes < len(self._buffer) and not self._out:
            self._acknowledge()

    def eof_received(self) -> bool:
        """Return False to close the socket, as the peer sends nothing more."""
        return False

    def connection_lost(self, exc: Exception | None) -> None:  # noqa: ARG002 - why does not matter
        """Clean up after the closed socket."""
        self._closing = True
        if self._lingering is not None:
            self._lingering.cancel()
        self._discount_unsent()
        self.peer.lost()
        self._sockets.lost(self)

    def pause_writing(self) -> None:
        """Record that the socket accepts bytes more slowly than they are written."""
        self.write_blocked = True

    def resume_writing(self) -> None:
        """Continue writing: the socket's buffer is almost empty again."""
        self.write_blocked = False
        self.count_unsent()
        self.peer.writable()

    def write(self, data: bytes) -> None:
        """Send *data* together with other writes of this turn of the loop."""
        if self._closing:
            return
        if not self._out:
            self._loop.call_soon(self._flush)
        self._out.append(data)
        self._out_size += len(data)
        if self._out_size > _MAX_JOINED_BYTES:
            self._flush()

    def pause_reading(self) -> None:
        """Leave incoming data in the kernel, so that the peer waits."""
        if self._transport is not None and not self._closing:
            self._transport.pause_reading()

    def resume_reading(self) -> None:
        """Read again."""
        if self._transport is not None and not self._closing:
            self._transport.resume_reading()

    def close(self, *, linger: bool) -> None:
        """Close after sending all written data.

        A socket closed with unread bytes makes the kernel reset the connection, and the peer loses the reason;
        so with *linger* only the sending half is closed, and incoming bytes are discarded for a moment.
        """
        if self._closing:
            return
        self._flush()
        self._closing = True
        if self._transport is None:
            return
        self._sockets.ends(self)
        if not linger:
            self._transport.close()
            return
        self._transport.resume_reading()
        self._lingering = self._loop.call_later(self._state.limits.linger, self._transport.abort)
        if not self._transport.can_write_eof():
            self._transport.close()
            return
        try:
            self._transport.write_eof()
        except OSError:  # the peer has reset the connection and cannot read the reason
            self._transport.abort()

    def end(self, reason: ReasonCode) -> None:
        """Close the connection cleanly: MQTT 5 clients get *reason*, and no will is published."""
        self.peer.end(reason, publish_will=False)

    def abort(self) -> None:
        """Cut the connection without a DISCONNECT."""
        self._closing = True
        if self._transport is not None:
            self._transport.abort()

    @property
    def unsent(self) -> int:
        """The bytes waiting for the socket."""
        return 0 if self._transport is None else self._transport.get_write_buffer_size()

    def cut_slow(self) -> None:
        """Cut the connection of a client that reads too slowly."""
        self._state.counters.clients_stalled += 1
        self._state.warn(
            "broker.client_stalled",
            f"the broker cut off {self.peer.client_text}: {self.unsent} bytes wait for its socket, "
            "more than for any other",
            address=self.address,
            unsent=self.unsent,
        )
        self.abort()
        self._discount_unsent()

    def report_tls_failure(self, reason: str) -> None:
        """Log that the TLS handshake with the client failed."""
        self._state.counters.connections_failed += 1
        self._state.warn(
            "broker.tls_failed",
            f"{self.address} and the broker could not establish TLS: {reason.lower().replace('_', ' ')}",
            address=self.address,
            reason=reason,
        )

    def count_unsent(self) -> int:
        """Update the total by the bytes waiting for the socket; return these."""
        size = self.unsent
        if size < _WORTH_COUNTING:
            size = 0
        change, self._counted = size - self._counted, size
        if change:
            self._sockets.unsent.add(change)
        return size

    def _discount_unsent(self) -> None:
        self._sockets.unsent.add(-self._counted)
        self._counted = 0

    def _acknowledge(self) -> None:
        """Make TCP acknowledge received data that gets no MQTT response.

        Linux delays that by up to 40 ms, during which a client with Nagle's algorithm, such as paho, sends nothing
        small.
        """
        if self._tcp is not None and _TCP_QUICKACK is not None and not self._closing:
            self._tcp.setsockopt(socket.IPPROTO_TCP, _TCP_QUICKACK, 1)

    def _limit_writing(self, large: int) -> None:
        self._large = large
        if self._transport is not None:
            self._transport.set_write_buffer_limits(high=self._state.limits.write_buffer + large)

    def _flush(self) -> None:
        if self._out and self._transport is not None:
            data = self._out[0] if len(self._out) == 1 else b"".join(self._out)
            self._out.clear()
            self._out_size = 0
            limit = self._state.limits.write_buffer
            if len(data) > limit and not self.write_blocked:
                self._limit_writing(len(data))
            elif self._large and self.unsent <= limit:
                self._limit_writing(0)
            self._transport.write(data)
            self.count_unsent()
