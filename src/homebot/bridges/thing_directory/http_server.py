"""A bounded HTTP server for other programs; the one file of the bridges that knows aiohttp.

A connection beyond the limit is answered with 503 and closed, and so is one on which no request comes in time. A client
that takes no bytes is cut off. A request in another version than HTTP/1.0 or 1.1 is answered with 505. Errors of the
library are logged in the server's name.
"""

import asyncio
import logging
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass
from typing import Final
from urllib.parse import unquote

import anyio
from aiohttp import HttpVersion11, web
from aiohttp.http_exceptions import HttpProcessingError

from homebot.bridges.admission import AccessSettings
from homebot.bridges.client_error_log import ClientErrorLog, LibraryLog
from homebot.clock import Clock
from homebot.errors import UsageError

__all__ = ["BoundedServer", "HttpExchange", "ServerCounters"]

FIRST_REQUEST_WITHIN: Final = 10.0
IDLE_FOR: Final = 30.0
BODY_WITHIN: Final = 10.0
TAKES_WITHIN: Final = 30.0
"""Timeouts in seconds: for the first request, between two, for a body, and for reading a response."""

_SWEEP_EVERY = 1.0
_MOST_SEGMENTS = 8
_LINE = 8190
_CLOSING = 0.5
_NOT_LET_IN: Final = frozenset({401, 403, 429})
"""Statuses after which a connection is closed: it would take the place of a client."""
_BUSY = b"HTTP/1.1 503 Service Unavailable\r\nRetry-After: 5\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
"""The response to one client too many."""
_CONTINUE = b"HTTP/1.1 100 Continue\r\n\r\n"
_OTHER_VERSION = b"HTTP/1.1 505 HTTP Version Not Supported\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
"""The response to HTTP/0.9 and HTTP/2, which the library would answer in the claimed version."""


@dataclass(slots=True)
class ServerCounters:
    """Numbers that only grow.

    Attributes:
        turned_away: Connections and requests that were not let in.
        clients_cut: Clients cut off because they sent no request, or took no bytes.
    """

    requests: int = 0
    turned_away: int = 0
    clients_cut: int = 0


class HttpExchange:
    """A request, and the way to answer it.

    Attributes:
        path: The parts of its path, decoded.
        query: The query, by name; of several of one name the last.
        target: Its path and query, as they were sent.
        body: Its body, once it was read.
    """

    def __init__(self, request: web.BaseRequest, counters: ServerCounters) -> None:
        self._request = request
        self._counters = counters
        self._stream: web.StreamResponse | None = None
        self.method = request.method
        segments = request.rel_url.raw_path.removeprefix("/").split("/", _MOST_SEGMENTS)
        self.path = tuple(unquote(one) for one in segments)
        self.target = str(request.rel_url)
        self.query: Mapping[str, str] = dict(request.query)
        self.address = str(request.remote or "unknown")
        self.body = b""

    @property
    def base(self) -> str:
        """The address of the server, as the client calls it."""
        return f"http://{self.headers('Host')[0]}"

    def headers(self, name: str) -> list[str]:
        """Return the values of all header fields of that name."""
        return self._request.headers.getall(name, [])

    async def read(self, limit: int) -> bool:
        """Read the body; return False where it is longer than *limit* bytes, or does not come in time."""
        if (self._request.content_length or 0) > limit:
            return False
        self._ask_for_body()
        body = bytearray()
        with anyio.move_on_after(BODY_WITHIN) as scope:
            while len(body) <= limit and not self._request.content.at_eof():
                body += await self._request.content.readany()
        self.body = bytes(body)
        return not scope.cancelled_caught and len(body) <= limit

    async def answer(self, status: int, headers: Mapping[str, str], body: bytes) -> None:
        """Send the answer; to HEAD without its body."""
        response = web.Response(status=status, headers=headers, body=body)
        if status in _NOT_LET_IN:
            response.force_close()
        self._stream = response
        async with self._in_time():
            await response.prepare(self._request)
            await response.write_eof()

    async def open_stream(self, headers: Mapping[str, str]) -> None:
        """Begin an answer that is sent piece by piece."""
        self._stream = web.StreamResponse(headers=headers)
        async with self._in_time():
            await self._stream.prepare(self._request)

    async def send(self, piece: bytes) -> None:
        """Send a piece of it; raise ConnectionError if the client has left, or takes no bytes."""
        if self._stream is not None:
            async with self._in_time():
                await self._stream.write(piece)

    def _ask_for_body(self) -> None:
        """Ask a client for the body that waits for that; the library does so in its own framework alone."""
        expected = self._request.headers.get("Expect", "").lower()
        if (
            expected == "100-continue"
            and self._request.version == HttpVersion11
            and self._request.transport is not None
        ):
            self._request.transport.write(_CONTINUE)

    @property
    def response(self) -> web.StreamResponse:
        """The response, as the library wants to have it."""
        return web.Response(status=500) if self._stream is None else self._stream

    @asynccontextmanager
    async def _in_time(self) -> AsyncIterator[None]:
        with anyio.move_on_after(TAKES_WITHIN) as scope:
            yield
        if scope.cancelled_caught:
            self._counters.clients_cut += 1
            if self._request.transport is not None:
                self._request.transport.abort()
            raise ConnectionResetError("the client takes no bytes")


class BoundedServer(web.Server):
    """A server that gives each request to a handler. Made while the event loop runs.

    Attributes:
        port: Its port; the real one once it listens.
    """

    def __init__(
        self,
        settings: AccessSettings,
        handle: Callable[[HttpExchange], Awaitable[None]],
        clock: Clock,
        error_log: ClientErrorLog,
    ) -> None:
        log = logging.Logger("thing_directory", logging.WARNING)  # noqa: LOG001 - leads into our own log
        log.addHandler(LibraryLog(error_log, "thing_directory", "a client sent invalid HTTP", _crash_in))
        super().__init__(
            self._serve,
            handler_cancellation=True,
            access_log=None,
            logger=log,
            keepalive_timeout=IDLE_FOR,
            max_line_size=_LINE,
            max_field_size=_LINE,
            lingering_time=_CLOSING,
            auto_decompress=False,
            read_bufsize=64 * 1024,
        )
        self.counters = ServerCounters()
        self.port = settings.port
        self.addresses: tuple[str, ...] = ()
        self._settings = settings
        self._handle = handle
        self._clock = clock
        self._silent: dict[web.RequestHandler, tuple[float, asyncio.Transport]] = {}

    @asynccontextmanager
    async def listening(self) -> AsyncIterator[None]:
        """Serve inside the block, then close all connections; raise UsageError if the address cannot be used."""
        settings = self._settings
        try:
            listener = await asyncio.get_running_loop().create_server(self, settings.host, settings.port)
        except OSError as exc:
            raise UsageError(f"thing_directory: {settings.listening_problem(exc, '[thing_directory] port')}") from exc
        self.port = listener.sockets[0].getsockname()[1]
        self.addresses = tuple(dict.fromkeys(one.getsockname()[0] for one in listener.sockets))
        try:
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._cut_silent)
                yield
                tasks.cancel_scope.cancel()
        finally:
            listener.close()
            with anyio.CancelScope(shield=True):
                self.pre_shutdown()
                await self.shutdown(_CLOSING)

    def connection_made(self, handler: web.RequestHandler, transport: asyncio.Transport) -> None:
        """Take a connection; where there are too many, in place of the oldest that has sent no request yet."""
        super().connection_made(handler, transport)
        if len(self.connections) > self._settings.max_clients and not self._silent:
            self.counters.turned_away += 1
            transport.write(_BUSY)
            transport.close()
            return
        if len(self.connections) > self._settings.max_clients:
            self._cut(next(iter(self._silent)))
        self._silent[handler] = (self._clock.monotonic(), transport)

    def connection_lost(self, handler: web.RequestHandler, exc: BaseException | None = None) -> None:
        """Forget a connection."""
        self._silent.pop(handler, None)
        super().connection_lost(handler, exc)

    async def _serve(self, request: web.BaseRequest) -> web.StreamResponse:
        self.counters.requests += 1
        if request.method != "OPTIONS":  # which is answered without a token
            self._silent.pop(request.protocol, None)  # from now on the library itself limits silence
        if request.version.major != 1:
            self.counters.turned_away += 1
            if request.transport is not None:
                request.transport.write(_OTHER_VERSION)
            request.protocol.force_close()
            return web.Response()
        exchange = HttpExchange(request, self.counters)
        with suppress(ConnectionError):  # the client has left
            await self._handle(exchange)
        return exchange.response

    async def _cut_silent(self) -> None:
        while True:
            await anyio.sleep(_SWEEP_EVERY)
            limit = self._clock.monotonic() - FIRST_REQUEST_WITHIN
            for handler, (began, _) in tuple(self._silent.items()):
                if began < limit:
                    self._cut(handler)

    def _cut(self, handler: web.RequestHandler) -> None:
        self.counters.clients_cut += 1
        self._silent.pop(handler)[1].abort()


def _crash_in(line: logging.LogRecord) -> str:
    error = line.exc_info[1] if line.exc_info else None
    return "" if error is None or isinstance(error, (HttpProcessingError, web.HTTPException)) else "a request failed"
