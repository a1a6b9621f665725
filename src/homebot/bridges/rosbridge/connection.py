"""A WebSocket connection of the rosbridge server that reads only as fast as that answers.

The session limits floods of frames, but the library itself answers pings and invalid frames, which are slowed down
here. A client that does not read is not read from either, as the answers to its pings would pile up.
"""

from __future__ import annotations

import asyncio
import re
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator, Mapping
from contextlib import suppress
from http import HTTPStatus
from typing import TYPE_CHECKING, Any, Final, Protocol, final

import anyio
from websockets.asyncio.server import ServerConnection
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.frames import DATA_OPCODES, CloseCode, Frame
from websockets.http11 import Response
from websockets.protocol import Event, State

from homebot.bridges.admission import token_of
from homebot.bridges.time_slices import ServerTurns
from homebot.errors import LinkError, WireError
from homebot.support.byte_account import ByteAccount

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.posted_request import PostedRequest

_READ = 2048
"""Bytes read at once: up to 340 of the smallest frames, about 5 ms of work for the library."""

_GET: Final = b"GET "
_MAX_OF_HEAD: Final = 16_384
_END_OF_HEAD: Final = re.compile(rb"\n\r?\n")
_BODY: Final = re.compile(rb"\n(?:content-length:\s*[1-9]|transfer-encoding:)", re.IGNORECASE)
_UPGRADE: Final = re.compile(rb"\nupgrade:", re.IGNORECASE)
_GO_AHEAD: Final = b"HTTP/1.1 100 Continue\r\n\r\n"

_OF_API: Final = {
    "Cache-Control": "no-store",
    "X-Content-Type-Options": "nosniff",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Connection": "close",
}
_CONTROL_HEADER: Final = 6
"""Bytes of a client's control frame in addition to its data."""

_MAX_ARRIVING: Final = 64
"""Most connections without a session; one more closes the oldest."""

_MAX_OF_ONE: Final = 131_072
"""Most bytes of a connection without a session: of a request to the HTTP API, and of a page that must log in."""


class PendingConnection(Protocol):
    """A connection."""

    transport: asyncio.Transport

    def cut_off(self, problem: str) -> None:
        """Close it at once because of *problem*."""
        ...


@final
class PendingConnections:
    """The connections without a session, oldest first, and the bytes of all that are not handled yet.

    Args:
        most: Most bytes of all connections together; above it, the one with the most is cut off.
    """

    def __init__(self, most: int) -> None:
        self._without_session: dict[PendingConnection, None] = {}
        self._bytes: dict[PendingConnection, int] = {}
        self._account = ByteAccount(most, lambda: self._bytes, lambda one: self._bytes.get(one, 0), self._cut)

    def __iter__(self) -> Iterator[PendingConnection]:
        return iter(tuple(self._without_session))

    def add(self, connection: PendingConnection) -> None:
        """Add a connection without a session."""
        self._bytes.setdefault(connection, 0)
        self._without_session[connection] = None
        if len(self._without_session) > _MAX_ARRIVING:
            self._cut(next(iter(self._without_session)))

    def has_session(self, connection: PendingConnection) -> None:
        """Record that *connection* has a session, or is being answered."""
        self._without_session.pop(connection, None)

    def hold(self, connection: PendingConnection, size: int) -> None:
        """Count *size* more bytes of *connection*, or fewer if negative."""
        if connection in self._bytes:
            self._bytes[connection] += size
            self._account.add(size)
            if connection in self._without_session and self._bytes[connection] > _MAX_OF_ONE:
                self._cut(connection)

    def remove(self, connection: PendingConnection) -> None:
        """Remove a connection that has ended."""
        self._without_session.pop(connection, None)
        self._account.add(-self._bytes.pop(connection, 0))

    def _cut(self, connection: PendingConnection) -> None:
        self.remove(connection)
        connection.cut_off("too many bytes of clients are incomplete or not handled")


class RosbridgeConnection(ServerConnection):
    """A connection that does not hold up the event loop.

    Args:
        pending: All connections; this one adds itself.
        open_timeout: Seconds within which the complete request must arrive.

    Attributes:
        posted: The request, if it is one that the library cannot read.
    """

    def __init__(
        self,
        turns: ServerTurns,
        pending: PendingConnections,
        open_timeout: float,
        *arguments: Any,
        **settings: Any,
    ) -> None:
        super().__init__(*arguments, **settings)
        self._turns = turns
        self._pending = pending
        self._sizes = deque([0])  # of messages that are not handled yet; the last one is incomplete
        self._holds: set[str] = set()
        self._is_lost = False
        self._is_heard = False
        self.posted: PostedRequest | None = None
        self._begun: bytes | None = b""
        self._has_head = False
        self._open_timeout = open_timeout
        self._too_late: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Start reading."""
        super().connection_made(transport)
        if hasattr(transport, "max_size"):  # asyncio has no other way to set it
            transport.max_size = _READ
        # The library also pauses reading, so one place tracks all reasons for it.
        self.recv_messages.pause = lambda: self._hold("queue")
        self.recv_messages.resume = lambda: self._release("queue")
        self._too_late = self.loop.call_later(self._open_timeout, self.transport.abort)
        self._pending.add(self)

    def data_received(self, data: bytes) -> None:
        """Handle *data* now or in the next turn; until then nothing more is read."""
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
        """Read again: the client accepts bytes."""
        super().resume_writing()
        self._release("writing")

    def connection_lost(self, exc: Exception | None) -> None:
        """Discard unsent data."""
        self._is_lost = True
        self._pending.remove(self)
        self.has_asked()
        super().connection_lost(exc)

    def is_excused(self) -> bool:
        """Return whether the client has been heard since the last call, or is not being read from.

        Not reading is no excuse for a client, because a vanished one does not read either.
        """
        was_heard, self._is_heard = self._is_heard, False
        return was_heard or not self._holds <= {"writing"}

    async def send_in_time(self, seconds: float, cut: Callable[[], None], frame: str | bytes) -> None:
        """Send *frame*; call *cut* if the client does not accept it within so many *seconds*.

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
        """The path and query of the request; empty until it is complete."""
        return "" if self.request is None else self.request.path

    def has_asked(self) -> None:
        """Record that the request is complete."""
        if self._too_late is not None:
            self._too_late.cancel()

    def has_arrived(self) -> None:
        """Record that the connection has a session, or is being answered."""
        self._pending.has_session(self)
        self.has_handled()

    def has_answer(self) -> None:
        """Record that the request has been answered, so that the connection may be closed like one without."""
        if not self._is_lost:
            self._pending.add(self)

    def hold(self, size: int) -> None:
        """Count *size* bytes from the client that are kept, or no longer if negative."""
        self._pending.hold(self, size)

    def has_handled(self) -> None:
        """Record that the request, or the oldest message, has been handled."""
        self.hold(-self._sizes.popleft())

    def cut_off(self, problem: str) -> None:
        """Close the connection at once because of *problem*."""
        if self.protocol.state is State.OPEN:
            self.protocol.fail(CloseCode.TRY_AGAIN_LATER, problem)
            self.send_data()
        self.transport.abort()

    def process_event(self, event: Event) -> None:
        """Handle *event*, and note where a message ends."""
        super().process_event(event)
        if isinstance(event, Frame) and event.opcode not in DATA_OPCODES:
            size = len(event.data) + _CONTROL_HEADER
            self._sizes[-1] -= size
            self.hold(-size)
        elif not isinstance(event, Frame) or event.fin:
            self._sizes.append(0)

    def _receive(self, data: bytes) -> None:
        if not self._is_lost:
            self._read(data)
            self._release("turn")

    def _read(self, data: bytes) -> None:
        """Pass *data* to the library; of other methods, or a GET with a body, only the head of the complete request.

        Bytes after a request are dropped, as the connection is closed after its answer.
        """
        if self._begun is not None:
            data, self._begun = self._begun + data, None
            if data[:1].isupper():
                data = self._begin(data)
        elif self._has_head:
            return
        if self.posted is not None:
            data = self._head(self.posted, data)
        if data:
            self._sizes[-1] += len(data)
            self.hold(len(data))
            super().data_received(data)

    def _begin(self, data: bytes) -> bytes:
        """Return what is passed on of the begin of a request; nothing until its head is complete."""
        end = _END_OF_HEAD.search(data)
        head = data[: end and end.end()]
        if end is None and len(data) < _MAX_OF_HEAD:
            self._begun = data
            return b""
        if not data.startswith(_GET) or _BODY.search(head):
            from homebot.bridges.rosbridge.posted_request import PostedRequest  # noqa: PLC0415 - few clients

            self.posted = PostedRequest()
        elif not _UPGRADE.search(head):
            self._has_head = True
            return head
        return data

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


async def client_frames(connection: RosbridgeConnection) -> AsyncIterator[str]:
    """Yield the frames of a client until it leaves; a binary frame ends the connection, unless it contains JSON.

    The original server accepts those too, and websocket-sharp, which ROS# uses, can only send bytes in that way.
    """
    try:
        async for frame in connection:
            text = frame if isinstance(frame, str) else _json_object(frame)
            if text is None:
                await connection.close(CloseCode.UNSUPPORTED_DATA, "the rosbridge server accepts only JSON in UTF-8")
                return
            yield text
            connection.has_handled()
    except ConnectionClosed:
        return


class HttpExchange:
    """A request and its answer, as an ASGI application has them; the answer is sent as a whole.

    Attributes:
        method: The method of the request.
        headers: Its head.
        token: The token in that; empty for none.
        local_address: The host and port at which it came.
        scope: The request without its body.
        response: The answer so far.
    """

    def __init__(self, connection: RosbridgeConnection) -> None:
        self._connection, self._is_read = connection, False
        self.response = Response(HTTPStatus.SERVICE_UNAVAILABLE, "homebot stops", Headers(_OF_API), b"")
        posted = connection.posted
        self.headers = headers = Headers() if connection.request is None else connection.request.headers
        self.token = token_of(headers.get_all("Authorization"))
        self.local_address: tuple[str, int] = connection.local_address[:2]
        path, _, query = connection.target.partition("?")
        self.method = "GET" if posted is None else posted.method
        self.scope: dict[str, object] = {
            "type": "http",
            "asgi": {"version": "3.0"},
            "http_version": "1.1",
            "method": self.method,
            "scheme": "http",
            "path": path,
            "raw_path": path.encode(),
            "query_string": query.encode(),
            "root_path": "",
            "headers": [(name.lower().encode(), value.encode()) for name, value in headers.raw_items()],
        }

    async def receive(self) -> dict[str, object]:
        """Return the body, and then that the client has left, once it has."""
        if self._is_read:
            await asyncio.wait([self._connection.connection_lost_waiter])
            return {"type": "http.disconnect"}
        self._is_read = True
        return {"type": "http.request", "body": self._connection.posted.body if self._connection.posted else b""}

    async def send(self, message: Mapping[str, Any]) -> None:
        """Send the begin, or a piece, of the answer."""
        if message["type"] == "http.response.start":
            status = HTTPStatus(message["status"])
            own = {name.lower() for name in _OF_API}
            given = [(name.decode(), value.decode()) for name, value in message["headers"]]
            headers = Headers([*(header for header in given if header[0].lower() not in own), *_OF_API.items()])
            self.response = Response(status, status.phrase, headers, b"")
        else:
            self.response.body += message.get("body", b"")

    def refuse(self, status: HTTPStatus, allow: str) -> None:
        """Answer with *status*, and the methods that there are."""
        headers = {"Allow": allow, "Content-Length": "0"} | _OF_API
        self.response = Response(status, status.phrase, Headers(headers), b"")


def http_response(status: HTTPStatus, content_type: str, body: bytes, allow: str = "") -> Response:
    """Return an answer of the HTTP API, which pages of other servers cannot load."""
    headers = {"Content-Type": content_type, "Content-Length": str(len(body))} | _OF_API
    headers |= {"Allow": allow} if allow else {}
    return Response(status.value, status.phrase, Headers(headers), body)


def is_roslibpy(connection: ServerConnection) -> bool:
    """Return whether the client is roslibpy, which (to 2.1 at least) reads no ``status`` frames."""
    agent = connection.request.headers.get("User-Agent", "") if connection.request is not None else ""
    return agent.startswith("AutobahnPython/")


def _json_object(frame: bytes) -> str | None:
    """Return the text of a binary frame; None if it cannot be a JSON object."""
    with suppress(UnicodeDecodeError):
        return frame.decode() if frame.lstrip()[:1] == b"{" else None
    return None
