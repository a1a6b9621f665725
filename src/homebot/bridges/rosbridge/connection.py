"""A WebSocket connection of the door that reads only as fast as the door answers.

A flood of frames reaches the session, which knows the limits; the library answers pings
and invalid frames by itself, so they are slowed down here. A client that does not read is not read from either:
otherwise the answers to its pings would pile up.
"""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final

import anyio
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import CloseCode
from websockets.http11 import Response

from homebot.bridges.turns import ServerTurns
from homebot.errors import LinkError, WireError

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.posted_request import PostedRequest

__all__ = ["DoorConnection", "client_frames", "http_response", "is_roslibpy"]

_READ = 2048
"""Bytes read at once: of the smallest frames 340, which take the library about 5 ms."""

_GET: Final = b"GET "
_GO_AHEAD: Final = b"HTTP/1.1 100 Continue\r\n\r\n"

_MOST_ARRIVING = 64
"""Connections without a request yet; one more ends the oldest."""


class DoorConnection(ServerConnection):
    """A connection that does not hold up the event loop.

    Args:
        arriving: The connections without a session, oldest first; this one adds itself.
        open_timeout: Seconds within which a whole request must come.

    Attributes:
        posted: The request, where it is none that the library reads by itself.
    """

    def __init__(
        self,
        turns: ServerTurns,
        arriving: dict[DoorConnection, None],
        open_timeout: float,
        *arguments: Any,
        **settings: Any,
    ) -> None:
        super().__init__(*arguments, **settings)
        self._turns = turns
        self._arriving = arriving
        self._holds: set[str] = set()
        self._is_lost = False
        self._is_heard = False
        self.posted: PostedRequest | None = None
        self._begun: bytes | None = b""
        self._open_timeout = open_timeout
        self._too_late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Begin to read."""
        super().connection_made(transport)
        if hasattr(transport, "max_size"):  # asyncio has no other way to set it
            transport.max_size = _READ
        # The library pauses reading for reasons of its own, so there is one place that knows them all.
        self.recv_messages.pause = lambda: self._hold("queue")
        self.recv_messages.resume = lambda: self._release("queue")
        self._too_late = self.loop.call_later(self._open_timeout, self.transport.abort)
        self._arriving[self] = None
        if len(self._arriving) > _MOST_ARRIVING:
            oldest = next(iter(self._arriving))
            del self._arriving[oldest]
            oldest.transport.abort()

    def data_received(self, data: bytes) -> None:
        """Handle *data* now or at the next turn; until then nothing more is read."""
        self._is_heard = True
        if self._turns.has_time():
            self._read(data)
            return
        self._hold("turn")
        self._turns.defer(lambda: self._receive(data))

    def pause_writing(self) -> None:
        """Stop reading from a client that does not read its answers."""
        super().pause_writing()
        self._hold("writing")

    def resume_writing(self) -> None:
        """Read again: the client takes bytes."""
        super().resume_writing()
        self._release("writing")

    def connection_lost(self, exc: Exception | None) -> None:
        """Discard unsent data."""
        self._is_lost = True
        self._arriving.pop(self, None)
        self.has_asked()
        super().connection_lost(exc)

    def is_excused(self) -> bool:
        """Return whether the client was heard since the last call, or is not being read from: it may say what it likes.

        A client that does not read is no excuse: nor does one that has vanished.
        """
        was_heard, self._is_heard = self._is_heard, False
        return was_heard or not self._holds <= {"writing"}

    async def send_in_time(self, seconds: float, cut: Callable[[], None], frame: str | bytes) -> None:
        """Send *frame*; a client that does not take it within so many *seconds* is *cut* off.

        Raises:
            LinkError: The client is gone.
        """
        with anyio.move_on_after(seconds) as limit:
            try:
                await self.send(frame)
            except ConnectionClosed as exc:
                raise LinkError("the client is gone") from exc
        if limit.cancelled_caught:
            cut()
            raise LinkError("the client is not reading")

    async def round_trip(self) -> None:
        """Return when the client has answered a ping, or is gone."""
        with suppress(ConnectionClosed):
            await (await self.ping())

    @property
    def target(self) -> str:
        """Path and query of the request; empty before it is whole."""
        return "" if self.request is None else self.request.path

    def has_asked(self) -> None:
        """Record that the whole request is there."""
        if self._too_late is not None:
            self._too_late.cancel()

    def has_arrived(self) -> None:
        """Record that the connection has a session, or is being answered."""
        self._arriving.pop(self, None)

    def has_answer(self) -> None:
        """Record that the request of the connection has its answer: it is ended like one without a request."""
        if not self._is_lost:
            self._arriving[self] = None

    def _receive(self, data: bytes) -> None:
        if not self._is_lost:
            self._read(data)
            self._release("turn")

    def _read(self, data: bytes) -> None:
        """Give *data* to the library; of a request with another method than GET its head, once it is whole."""
        if self._begun is not None:
            data, self._begun = self._begun + data, None
            if len(data) < len(_GET) and _GET.startswith(data):
                self._begun = data
                return
            if not data.startswith(_GET) and data[:1].isupper():
                from homebot.bridges.rosbridge.posted_request import PostedRequest  # noqa: PLC0415 - few clients post

                self.posted = PostedRequest()
        if self.posted is not None:
            data = self._head(self.posted, data)
        if data:
            super().data_received(data)

    def _head(self, posted: PostedRequest, data: bytes) -> bytes:
        try:
            head = posted.receive(data)
        except WireError as exc:
            self.logger.error("bad HTTP request", exc_info=exc)
            problem = http_response(HTTPStatus.BAD_REQUEST, "text/plain; charset=utf-8", f"{exc}\n".encode())
            self.transport.write(problem.serialize())
            self.transport.close()
            return b""
        if posted.waits_for_go_ahead:
            self.transport.write(_GO_AHEAD)
        return head

    def _hold(self, why: str) -> None:
        if not self._holds and not self._is_lost:
            self.transport.pause_reading()
        self._holds.add(why)

    def _release(self, why: str) -> None:
        self._holds.discard(why)
        if not self._holds and not self._is_lost:
            self.transport.resume_reading()


async def client_frames(connection: ServerConnection) -> AsyncIterator[str]:
    """Yield the frames of a client until it leaves; a binary one ends the connection, unless it holds JSON.

    The original server takes those too, and websocket-sharp, which ROS# uses, sends bytes in no other way.
    """
    try:
        async for frame in connection:
            text = frame if isinstance(frame, str) else _json_object(frame)
            if text is None:
                await connection.close(CloseCode.UNSUPPORTED_DATA, "the rosbridge server accepts only JSON in UTF-8")
                return
            yield text
    except ConnectionClosed:
        return


def http_response(status: HTTPStatus, content_type: str, body: bytes, allow: str = "") -> Response:
    """Return an answer of the HTTP API, which no page of another server can load."""
    headers = {
        "Content-Type": content_type,
        "Content-Length": str(len(body)),
        "Cache-Control": "no-store",
        "X-Content-Type-Options": "nosniff",
        "Cross-Origin-Resource-Policy": "same-origin",
        "Connection": "close",
        **({"Allow": allow} if allow else {}),
    }
    return Response(status.value, status.phrase, Headers(headers), body)


def is_roslibpy(connection: ServerConnection) -> bool:
    """Return whether the client is roslibpy, which (to 2.1 at least) reads neither PNG nor ``status`` frames."""
    agent = connection.request.headers.get("User-Agent", "") if connection.request is not None else ""
    return agent.startswith("AutobahnPython/")


def _json_object(frame: bytes) -> str | None:
    """Return the text of a binary frame; None where it cannot be that of a JSON object."""
    with suppress(UnicodeDecodeError):
        return frame.decode() if frame.lstrip()[:1] == b"{" else None
    return None
