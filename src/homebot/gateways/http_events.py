"""An open stream of server-sent events; a helper of :mod:`homebot.gateways.http_client`."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable

from homebot.errors import LinkError
from homebot.gateways.event_stream import EventStreamParser, ServerEvent
from homebot.gateways.http_errors import translated_errors

__all__ = ["EventStream"]


class EventStream:
    """An open stream of server-sent events, for ``async for``; it ends with an error, as a server never ends it.

    Args:
        read: Waits for bytes, and returns them; none at the end of the answer.
        where: The address, for errors.
        parser: Makes events of them.

    Raises:
        LinkError: The connection was closed or is lost; ask again with :attr:`last_id`, after :attr:`retry` seconds.
        WireError: An event is too long, or the stream breaks the rules of HTTP.
    """

    def __init__(self, read: Callable[[], Awaitable[bytes]], where: str, parser: EventStreamParser) -> None:
        self._read = read
        self._where = where
        self._parser = parser

    @property
    def last_id(self) -> str:
        """The id of the last event that had one."""
        return self._parser.last_id

    @property
    def retry(self) -> float | None:
        """Seconds after which the server wants to be asked again; None if it does not say."""
        return self._parser.retry

    async def __aiter__(self) -> AsyncIterator[ServerEvent]:
        while True:
            with translated_errors("GET", self._where):
                chunk = await self._read()
            if not chunk:
                raise LinkError(f"{self._where} ended the stream of events")
            for event in self._parser.feed(chunk):
                yield event
