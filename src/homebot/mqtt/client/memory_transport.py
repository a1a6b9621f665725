"""A link without a socket between a client and the broker on one event loop.

Bytes written in one turn of the loop arrive together in the next. Without threads, sockets and waiting, it also works
in virtual time.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import final

from homebot.errors import LinkError
from homebot.mqtt.broker import BrokerState, Peer
from homebot.mqtt.client.transport import TransportUser


@final
class MemoryLink:
    """The broker's end; a :class:`homebot.mqtt.broker.Transport`.

    The buffer for a client that does not read has no limit of its own: above ``limits.write_buffer`` the link is
    *choked*, and the broker writes nothing more that can wait.
    """

    def __init__(
        self, state: BrokerState, user: TransportUser, address: str, on_closed: Callable[[MemoryLink], None]
    ) -> None:
        loop = asyncio.get_running_loop()
        self.write_blocked = False
        self.address = address
        self.peer = Peer(state, self)
        self._state = state
        self._loop = loop
        self._user = user
        self._on_closed = on_closed
        self._down = _Pipe(loop, self._hand_down, self._notify_end)
        self._up = _Pipe(loop, self._hand_up, self.abort)
        self._closing = False
        self._large = 0  # bytes of a message that fills the buffer alone
        self.socket = MemorySocket(self._up, self._down)

    def write(self, data: bytes) -> None:
        """Send *data* with all else of this turn of the loop."""
        if not self._closing:
            limit = self._state.limits.write_buffer
            if len(data) > limit and not self.write_blocked:
                self._large = len(data)
            self._down.write(data)
            self.write_blocked = self._down.size > limit + self._large

    def pause_reading(self) -> None:
        """Leave the client's bytes at its end."""
        self._up.pause()

    def resume_reading(self) -> None:
        """Take bytes again."""
        self._up.resume()

    def close(self, *, linger: bool) -> None:  # noqa: ARG002 - in memory no reason is ever lost
        """Send all written data, then close."""
        if not self._closing:
            self._closing = True
            self._down.end()
            self._loop.call_soon(self._finish)

    def abort(self) -> None:
        """Cut the link as if the client had vanished: data in transit is lost, and the will is published."""
        if not self._closing:
            self._closing = True
            self._down.cut()
            self._loop.call_soon(self._finish)

    def freeze(self) -> None:
        """Stop all traffic silently, as if a cable were pulled; bytes wait."""
        self._up.freeze()
        self._down.freeze()

    def thaw(self) -> None:
        """Resume traffic, waiting data first."""
        self._up.thaw()
        self._down.thaw()

    def _finish(self) -> None:
        self._up.cut()
        self.peer.lost()
        self._on_closed(self)

    def _hand_up(self, data: bytes) -> None:
        if self._closing:
            return
        self._state.receive(self.peer, data, self.address)
        if not self._up.size:
            self._user.drained()

    def _notify_end(self) -> None:
        self._user.link_ended(LinkError("the broker closed the connection"))

    def _hand_down(self, data: bytes) -> None:
        self._user.data_received(data)
        self._large = 0
        if self.write_blocked:
            self.write_blocked = False
            self.peer.writable()


@final
class MemorySocket:
    """The client's end of a link; a :class:`homebot.mqtt.client.transport.ClientTransport`.

    Made by :meth:`homebot.mqtt.memory_broker.MemoryBroker.dial`.
    """

    def __init__(self, up: _Pipe, down: _Pipe) -> None:
        self._up = up
        self._down = down

    @property
    def waiting(self) -> int:
        """Written bytes that the broker has not read yet."""
        return self._up.size

    def write(self, data: bytes) -> None:
        """Send *data* with all else of this turn of the loop; nothing after a close."""
        self._up.write(data)

    def write_acknowledgements(self, data: bytes) -> None:
        """Send *data* at once: in memory, waiting saves nothing."""
        self._up.write(data)

    def pause_reading(self) -> None:
        """Stop reading from the broker, to which this client then appears slow."""
        self._down.pause()

    def resume_reading(self) -> None:
        """Take bytes again."""
        self._down.resume()

    def close(self) -> None:
        """Send all written data, then close; nothing more is received."""
        self._down.deafen()
        self._up.end()

    async def wait_closed(self) -> None:
        """Return at once: written data always arrives."""

    def abort(self) -> None:
        """Cut the link: unread data is lost, and nothing more is received."""
        self._down.deafen()
        self._up.cut()


@final
class _Pipe:
    """One direction; *deliver* gets the bytes a turn later, *ended* is called once after the last of them."""

    def __init__(
        self, loop: asyncio.AbstractEventLoop, deliver: Callable[[bytes], None], ended: Callable[[], None]
    ) -> None:
        self.size = 0
        self._loop = loop
        self._deliver: Callable[[bytes], None] | None = deliver
        self._ended: Callable[[], None] | None = ended
        self._waiting: list[bytes] = []
        self._scheduled = False
        self._paused = False
        self._frozen = False
        self._ending = False

    def write(self, data: bytes) -> None:
        if data and not self._ending:
            self._waiting.append(data)
            self.size += len(data)
            self._schedule()

    def end(self) -> None:
        self._ending = True
        self._schedule()

    def cut(self) -> None:
        self._waiting.clear()
        self.size = 0
        self.end()

    def deafen(self) -> None:
        """Discard incoming data from now on."""
        self._deliver = self._ended = None
        self.resume()

    def pause(self) -> None:
        self._paused = True

    def resume(self) -> None:
        self._paused = False
        self._schedule()

    def freeze(self) -> None:
        self._frozen = True

    def thaw(self) -> None:
        self._frozen = False
        self._schedule()

    def _schedule(self) -> None:
        if not self._scheduled:
            self._scheduled = True
            self._loop.call_soon(self._run)

    def _run(self) -> None:
        self._scheduled = False
        if self._waiting and not self._paused and not self._frozen:
            data = self._waiting[0] if len(self._waiting) == 1 else b"".join(self._waiting)
            self._waiting.clear()
            self.size = 0
            if self._deliver is not None:
                self._deliver(data)
        if self._ending and not self._waiting and not self._frozen:
            ended, self._ended = self._ended, None
            if ended is not None:
                ended()
