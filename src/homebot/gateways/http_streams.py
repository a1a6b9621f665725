"""Open WebSockets and streams of server-sent events; helpers of :mod:`homebot.gateways.http_client`.

Source: RFC 6455.
"""

from collections.abc import AsyncIterator, Awaitable, Callable
from typing import Final, NoReturn

import aiohttp
import anyio
import anyio.lowlevel

from homebot.conventions.payload import clean_text
from homebot.errors import LinkError, WireError
from homebot.gateways.event_stream import EventStreamParser, ServerEvent
from homebot.gateways.http_errors import translated_errors

MAX_INVALID: Final = 20
"""Invalid messages in a row after which nothing more is read."""


class WebSocket:
    """An open WebSocket. Any task may send; one at a time may receive.

    Args:
        time_limit: Seconds in which a message has to be sent.
    """

    def __init__(self, opened: aiohttp.ClientWebSocketResponse, where: str, time_limit: float) -> None:
        self._opened = opened
        self._where = where
        self._time_limit = time_limit

    async def send(self, message: str | bytes) -> None:
        """Send a message: text, or binary where it is bytes.

        Raises:
            LinkError: The connection is lost, or so slow that the message could not be sent in time.
        """
        try:
            with anyio.fail_after(self._time_limit), translated_errors("WebSocket", self._where):
                if isinstance(message, str):
                    await self._opened.send_str(message)
                else:
                    await self._opened.send_bytes(message)
        except TimeoutError:
            raise LinkError(f"{self._where} takes no message") from None

    async def receive(self) -> str | bytes:
        """Wait for a message, and return it.

        Raises:
            LinkError: The connection was closed or is lost.
            WireError: A message breaks the rules, or is too long; no other can follow.
        """
        message = await self._next()
        if message.type is aiohttp.WSMsgType.TEXT or message.type is aiohttp.WSMsgType.BINARY:
            data: str | bytes = message.data
            return data
        if message.type is aiohttp.WSMsgType.ERROR and isinstance(message.data, aiohttp.WebSocketError):
            raise WireError(f"{self._where} broke the rules of WebSockets: {clean_text(str(message.data), 80)}")
        raise LinkError(f"{self._where} closed the connection")

    async def receive_all(
        self, take: Callable[[bytes], Awaitable[None]], reject: Callable[[bytes, str], None]
    ) -> NoReturn:
        """Pass each message to *take*, as bytes, until the connection is lost.

        Args:
            reject: Told of each invalid message, and why.

        Raises:
            LinkError: The connection was closed or is lost.
            WireError: 20 messages in a row were invalid; or as :meth:`receive`.
        """
        invalid = 0
        while True:
            message = await self.receive()
            payload = message.encode(errors="replace") if isinstance(message, str) else message
            try:
                await take(payload)
                invalid = 0
            except WireError as exc:
                reject(payload, str(exc))
                invalid += 1
                if invalid >= MAX_INVALID:
                    raise WireError(f"{self._where} sent {invalid} invalid messages in a row") from exc

    async def _next(self) -> aiohttp.WSMessage:
        """Return the next message that is not a ping or a pong, answering pings."""
        with translated_errors("WebSocket", self._where):
            while True:
                await anyio.lowlevel.checkpoint()  # receiving buffered data lets no other task run
                message = await self._opened.receive()
                if message.type is aiohttp.WSMsgType.PING:
                    await self._opened.pong(message.data)
                elif message.type is not aiohttp.WSMsgType.PONG:
                    return message


class EventStream:
    """An open stream of server-sent events, for ``async for``; it ends with an error, as a server never ends it.

    Raises:
        LinkError: The connection was closed or is lost.
        WireError: An event is too long, or the stream breaks the rules of HTTP.
    """

    def __init__(self, read: Callable[[], Awaitable[bytes]], where: str, parser: EventStreamParser) -> None:
        self._read = read
        self._where = where
        self._parser = parser

    async def __aiter__(self) -> AsyncIterator[ServerEvent]:
        while True:
            with translated_errors("GET", self._where):
                chunk = await self._read()
            if not chunk:
                raise LinkError(f"{self._where} ended the stream of events")
            for event in self._parser.feed(chunk):
                yield event
