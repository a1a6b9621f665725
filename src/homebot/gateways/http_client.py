"""A client for HTTP, WebSockets and server-sent events; only it and its helpers use aiohttp.

The caller limits the length of answers, frames and events; everything has a time limit except waiting for the next
frame or event. There are three errors: :class:`LinkError`, it may work later; :class:`RefusedError`, the server
refuses, with the status as code; :class:`WireError`, it breaks the protocol. No error shows a password or the query of
an address.

Source: RFC 9110 (HTTP), RFC 6455 (WebSocket).
"""

import re
import socket
import ssl
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, field
from types import TracebackType
from typing import Final, Self

import aiohttp
import anyio
from yarl import URL

from homebot.conventions.payload import compact_json, parse_json, shown
from homebot.errors import LinkError, RefusedError, WireError
from homebot.gateways.address_guard import AddressGuard
from homebot.gateways.event_stream import EventStreamParser
from homebot.gateways.http_address import parse_url, shown_url
from homebot.gateways.http_errors import check_status, translated_errors
from homebot.gateways.http_middlewares import authentication, follow_own_redirects, staying_at
from homebot.gateways.http_streams import EventStream, WebSocket
from homebot.gateways.password_settings import HttpLogin
from homebot.support.unanswered import SENT_REQUESTS

MAX_ANSWER_BYTES: Final = 256 * 1024
"""Default for the longest answer, frame and event, in bytes."""

TIME_LIMIT: Final = 10.0
"""Default for the seconds of an answer, a connection or one sent frame."""

HEARTBEAT: Final = 16.0
"""Seconds of silence after which a WebSocket is pinged; without an answer within half of that it is lost."""

_METHOD = re.compile(r"[A-Z]{1,20}(-[A-Z]{1,20})?")
_CLOSING: Final = 1.0
_RECEIVED_AT_ONCE: Final = 8 * 1024
"""Bytes; Linux doubles it. Everything received is parsed without a pause; 256 KiB of tiny frames take a second."""
_REDIRECTS: Final = 3


@dataclass(frozen=True, slots=True)
class HttpAnswer:
    """An answer with a status from 200 to 299, or 304.

    Attributes:
        status: The status; 304 if the content still has the ETag that was sent.
        content_type: The media type in lower case, without parameters; empty if there is none.
        headers: All header fields, names in lower case; those that occur several times are joined by commas.
    """

    status: int
    content_type: str
    body: bytes
    headers: Mapping[str, str] = field(default_factory=dict)

    def json(self) -> object:
        """Return the body, parsed as JSON.

        Raises:
            WireError: It is none; see :func:`homebot.conventions.payload.parse_json`.
        """
        return parse_json(self.body, max(len(self.body), 1), lenient=True)


class HttpClient:
    """A session with servers for concurrent requests; use it as ``async with``.

    Args:
        guard: The guard of this computer's addresses, redirects included; None for addresses that the owner configured.
        tls: The check of server certificates under the scheme ``https``; by default against the certificate
            authorities of this computer.
        time_limit: Seconds; see the methods.
        max_bytes: Longest answer, frame or event; likewise.
    """

    def __init__(
        self,
        *,
        guard: AddressGuard | None,
        login: HttpLogin | None = None,
        tls: ssl.SSLContext | None = None,
        time_limit: float = TIME_LIMIT,
        max_bytes: int = MAX_ANSWER_BYTES,
    ) -> None:
        self._guard = guard
        self._login = login
        self._tls = tls
        self._time_limit = time_limit
        self._max_bytes = max_bytes
        self._session: aiohttp.ClientSession | None = None

    async def __aenter__(self) -> Self:
        self._session = aiohttp.ClientSession(
            connector=aiohttp.TCPConnector(
                ssl=True if self._tls is None else self._tls, socket_factory=self._make_socket
            ),
            # Bodies are not decompressed, so their limit holds as they arrive. Time is limited below.
            auto_decompress=False,
            cookie_jar=aiohttp.DummyCookieJar(),
            headers={"Accept-Encoding": "identity", "User-Agent": "homebot"},
            middlewares=(follow_own_redirects, *(() if self._login is None else (authentication(self._login),))),
            timeout=aiohttp.ClientTimeout(total=None, sock_connect=None),
            trace_configs=[_marking_sent()],
        )
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
        session, self._session = self._session, None
        if session is not None:
            with anyio.CancelScope(shield=True):
                await session.close()

    async def get(self, url: str, *, accept: str = "", max_bytes: int | None = None) -> HttpAnswer:
        """Return the answer to GET; at most three redirects within the host are followed. See also :meth:`request`."""
        return await self.request("GET", url, accept=accept, max_bytes=max_bytes)

    async def get_json(self, url: str) -> object:
        """Return the answer to GET, parsed as JSON; see :meth:`request`."""
        return (await self.get(url, accept="application/json")).json()

    async def send_json(self, method: str, url: str, value: object) -> object | None:
        """Send *value* as JSON, by PUT or POST, and return the answer, parsed as JSON.

        Returns:
            The value; None if the answer has no body.
        """
        body = compact_json(value).encode()
        answer = await self.request(method, url, body=body, content_type="application/json", accept="application/json")
        return answer.json() if answer.body else None

    async def request(
        self,
        method: str,
        url: str,
        *,
        body: bytes | None = None,
        content_type: str = "",
        accept: str = "",
        max_bytes: int | None = None,
    ) -> HttpAnswer:
        """Send a request, and return the answer.

        Args:
            url: Where; ``http`` or ``https``, without a user or a password.
            accept: The media types that are understood; empty for any.
            max_bytes: Longest body of the answer; by default that of the client.

        Raises:
            LinkError: The server cannot be reached, is too slow, breaks off, or says that it may work later (408, 425,
                429, 502, 503, 504).
            RefusedError: It answers with another status that is not 2xx; that is the code.
            WireError: It breaks the rules of HTTP, the answer is too long or is compressed, *url* is no address, or
                *method* or a media type is none.
        """
        if not _METHOD.fullmatch(method):
            raise WireError(f"{shown(method)} is no method of HTTP")
        where = parse_url(url)
        headers = _headers(accept, content_type)
        async with self._within(method, where, self._time_limit):
            response = await self._open().request(
                method, where, data=body, headers=headers, allow_redirects=method == "GET", max_redirects=_REDIRECTS
            )
            SENT_REQUESTS.get().is_unanswered = False
            async with response:
                check_status(f"{method} {shown_url(where)}", response.status, has_login=self._login is not None)
                data = await _body(where, response, self._max_bytes if max_bytes is None else max_bytes)
                return HttpAnswer(response.status, _media_type(response), data, _fields(response))

    @asynccontextmanager
    async def websocket(
        self, url: str, *, max_bytes: int | None = None, heartbeat: float = HEARTBEAT
    ) -> AsyncIterator[WebSocket]:
        """Keep a WebSocket open inside the block.

        Args:
            url: Where; ``http``, ``https``, ``ws`` or ``wss``.
            max_bytes: Longest frame that may come; by default that of the client.
            heartbeat: Seconds of silence after which it is asked whether it is still there.
        """
        where = parse_url(url, "http", "https", "ws", "wss")
        async with self._within("WebSocket", where, self._time_limit):
            opened = await self._open().ws_connect(
                where,
                autoping=False,  # it would answer all that came without a pause
                heartbeat=heartbeat,
                max_msg_size=self._max_bytes if max_bytes is None else max_bytes,
                timeout=aiohttp.ClientWSTimeout(ws_close=_CLOSING),
            )
        try:
            yield WebSocket(opened, shown_url(where), self._time_limit)
        finally:
            with anyio.move_on_after(_CLOSING, shield=True):
                await opened.close()

    @asynccontextmanager
    async def events(self, url: str, *, max_bytes: int | None = None) -> AsyncIterator[EventStream]:
        """Keep a stream of server-sent events open inside the block.

        Args:
            max_bytes: Longest event; by default that of the client.

        Raises:
            RefusedError: As :meth:`request`; or the status is 204, which tells a client to stop asking.
        """
        where = parse_url(url)
        headers = {**_headers("text/event-stream", ""), "Cache-Control": "no-store"}
        async with self._within("GET", where, self._time_limit):
            response = await self._open().get(where, headers=headers, max_redirects=_REDIRECTS)
        async with response:
            check_status(f"GET {shown_url(where)}", response.status, has_login=self._login is not None)
            if response.status == 204:
                raise RefusedError(f"GET {shown_url(where)}", "there are no events any more", 204)
            if (media_type := _media_type(response)) != "text/event-stream":
                raise WireError(f"{shown_url(where)} sends {media_type[:60] or 'nothing that has a type'}, not events")
            parser = EventStreamParser(self._max_bytes if max_bytes is None else max_bytes)
            yield EventStream(response.content.readany, shown_url(where), parser)

    def _make_socket(self, found: aiohttp.AddrInfoType) -> socket.socket:
        """Return a socket that takes little at once, which aiohttp connects to the address *found*."""
        *kind, _, address = found
        if self._guard is not None:
            self._guard.check(address)
        made = socket.socket(*kind)
        made.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVED_AT_ONCE)
        return made

    def _open(self) -> aiohttp.ClientSession:
        if self._session is None:
            raise LinkError("the connection was closed")
        return self._session

    @asynccontextmanager
    async def _within(self, what: str, where: URL, time_limit: float) -> AsyncIterator[None]:
        try:
            with (
                anyio.fail_after(time_limit),
                staying_at(where),
                translated_errors(what, shown_url(where), has_login=self._login is not None),
            ):
                yield
        except TimeoutError:
            raise LinkError(f"{shown_url(where)} did not answer within {time_limit:g} s") from None


def _marking_sent() -> aiohttp.TraceConfig:
    """Return a configuration that marks each request that may change something once its head was written."""

    async def mark(_: object, __: object, request: aiohttp.TraceRequestHeadersSentParams) -> None:
        if request.method != "GET":
            SENT_REQUESTS.get().is_unanswered = True

    tracing = aiohttp.TraceConfig()
    tracing.on_request_headers_sent.append(mark)
    return tracing


def _headers(accept: str, content_type: str) -> dict[str, str]:
    """Return header fields with values that may be from outside."""
    given = {"Accept": accept or "*/*", "Content-Type": content_type}
    for name, value in given.items():
        if not (value.isascii() and value.isprintable()):
            raise WireError(f"{shown(value)} is no {name}")
    return {name: value for name, value in given.items() if value}


def _media_type(response: aiohttp.ClientResponse) -> str:
    return response.headers.get("Content-Type", "").partition(";")[0].strip().lower()


def _fields(response: aiohttp.ClientResponse) -> dict[str, str]:
    fields: dict[str, str] = {}
    for name, value in response.headers.items():
        key = name.lower()
        fields[key] = f"{fields[key]}, {value}" if key in fields else value
    return fields


async def _body(where: URL, response: aiohttp.ClientResponse, max_bytes: int) -> bytes:
    if response.headers.get("Content-Encoding", "identity").strip().lower() not in {"identity", ""}:
        raise WireError(f"{shown_url(where)} answers with compressed bytes, which were not requested")
    if response.content_length is not None and response.content_length > max_bytes:
        raise _too_long(where, max_bytes)
    data = bytearray()
    while chunk := await response.content.readany():
        data += chunk
        if len(data) > max_bytes:
            raise _too_long(where, max_bytes)
    return bytes(data)


def _too_long(where: URL, max_bytes: int) -> WireError:
    return WireError(f"{shown_url(where)} answers with more than {max_bytes} bytes")
