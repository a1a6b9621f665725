"""The client of a directory of things: the whole list, single descriptions, and what changes.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, section 7.3.2.
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final
from urllib.parse import quote

from yarl import URL

from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES
from homebot.errors import RefusedError, WireError
from homebot.gateways.http_address import parse_url
from homebot.gateways.http_client import HttpClient
from homebot.gateways.http_events import EventStream
from homebot.gateways.long_json import parse_long_json
from homebot.gateways.thing_directory.documents import members_of, next_page

__all__ = ["DirectoryReader"]

PAGE: Final = 50
"""Things of one page, where the directory can count."""

MAX_PAGE_BYTES: Final = 8 * 1024 * 1024
"""Longest page: a directory that cannot count answers with all things at once."""

MAX_PAGES: Final = 1000

_ACCEPTED = "application/ld+json, application/json;q=0.9"
_TD = "application/td+json, application/json;q=0.9"
_CANNOT_COUNT = frozenset({400, 422, 501})


class DirectoryReader:
    """A directory, as far as it is read.

    Args:
        url: The address below which it has ``/things`` and ``/events``.
        client: The client, with the directory's credentials.
    """

    def __init__(self, url: str, client: HttpClient) -> None:
        self._url = url
        self._origin = parse_url(url).origin()
        self._client = client

    async def pages(self) -> AsyncIterator[list[object]]:
        """Yield what each page lists, until the last.

        Raises:
            LinkError: The directory does not answer.
            RefusedError: It does not let homebot in, or has no list.
            WireError: It breaks the rules, or leads to another server, or around in a circle.
        """
        where, is_first = f"{self._url}/things?limit={PAGE}", True
        seen: set[str] = set()
        while where:
            if where in seen or len(seen) >= MAX_PAGES:
                raise WireError(f"the list of the directory does not end after {len(seen)} pages")
            seen.add(where)
            try:
                answer = await self._client.get(where, accept=_ACCEPTED, max_bytes=MAX_PAGE_BYTES)
            except RefusedError as exc:
                if not is_first or exc.code not in _CANNOT_COUNT:
                    raise
                answer = await self._client.get(f"{self._url}/things", accept=_ACCEPTED, max_bytes=MAX_PAGE_BYTES)
            is_first = False
            page = await parse_long_json(answer.body, MAX_PAGE_BYTES)
            yield members_of(page)
            where = self._resolved(where, next_page(page, answer.headers))

    async def retrieve(self, thing_id: str) -> bytes | None:
        """Return the description of one thing; None where the directory has it no longer.

        Raises:
            LinkError, RefusedError, WireError: As :meth:`pages`.
        """
        where = f"{self._url}/things/{quote(thing_id, safe='')}"
        try:
            return (await self._client.get(where, accept=_TD, max_bytes=MAX_ANNOUNCEMENT_BYTES)).body
        except RefusedError as exc:
            if exc.code in {404, 410}:
                return None
            raise

    @asynccontextmanager
    async def events(self) -> AsyncIterator[EventStream]:
        """Open the stream of what changes; whole descriptions come where the directory can send them.

        Raises:
            LinkError: The directory does not answer.
            RefusedError: It does not tell what changes, or does not let homebot in.
            WireError: What it sends are no events.
        """
        try:
            async with self._client.events(f"{self._url}/events?diff=true", max_bytes=MAX_ANNOUNCEMENT_BYTES) as stream:
                yield stream
                return
        except RefusedError as exc:
            if exc.code not in _CANNOT_COUNT:
                raise
        async with self._client.events(f"{self._url}/events", max_bytes=MAX_ANNOUNCEMENT_BYTES) as stream:
            yield stream

    def _resolved(self, page: str, following: str) -> str:
        if not following:
            return ""
        try:
            where = URL(page).join(URL(following))
        except ValueError:
            raise WireError("the next page of the list has no address") from None
        if where.origin() != self._origin:
            raise WireError("the next page of the list is on another server")
        return str(where)
