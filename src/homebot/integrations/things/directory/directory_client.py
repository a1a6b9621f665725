"""The client of a directory of things: the whole list, single descriptions, and changes.

Source: W3C Recommendation "Web of Things (WoT) Discovery", 5 December 2023, section 7.3.2.
"""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Final
from urllib.parse import quote

from yarl import URL

from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES
from homebot.errors import RefusedError, WireError
from homebot.gateways.http_address import parse_url
from homebot.gateways.http_client import HttpAnswer, HttpClient
from homebot.gateways.http_streams import EventStream
from homebot.gateways.long_json import parse_long_json
from homebot.integrations.things.directory.documents import members_of, next_page

PAGE: Final = 50
"""Things per page, if the directory can paginate."""

MAX_PAGE_BYTES: Final = 8 * 1024 * 1024
"""Longest page: a directory that cannot paginate answers with all things at once."""

MAX_PAGES: Final = 1000

_ACCEPTED = "application/ld+json, application/json;q=0.9"
_TD = "application/td+json, application/json;q=0.9"
_CANNOT_COUNT = frozenset({400, 422, 501})


class DirectoryReader:
    """The reader of a directory.

    Args:
        url: The address below which it has ``/things`` and ``/events``.
    """

    def __init__(self, url: str, client: HttpClient) -> None:
        self._url = url
        self._origin = parse_url(url).origin()
        self._client = client
        self._can_count = True

    async def pages(self) -> AsyncIterator[list[object]]:
        """Yield the descriptions on each page.

        Raises:
            LinkError: The directory does not answer.
            RefusedError: It refuses homebot, or has no list.
            WireError: It breaks the rules, or its pages lead to another server or in a circle.
        """
        where = f"{self._url}/things?limit={PAGE}" if self._can_count else f"{self._url}/things"
        seen: set[str] = set()
        while where:
            if where in seen or len(seen) >= MAX_PAGES:
                raise WireError(f"the list of the directory does not end after {len(seen)} pages")
            seen.add(where)
            answer = await self._get_page(where, is_first=len(seen) == 1)
            if answer is None:
                where = f"{self._url}/things"
                continue
            document = await parse_long_json(answer.body, MAX_PAGE_BYTES)
            yield members_of(document)
            where = self._resolve(where, next_page(document, answer.headers))

    async def _get_page(self, where: str, *, is_first: bool) -> HttpAnswer | None:
        """Return the answer with a page; None if the directory turns out not to paginate."""
        try:
            return await self._client.get(where, accept=_ACCEPTED, max_bytes=MAX_PAGE_BYTES)
        except RefusedError as exc:
            if not is_first or not self._can_count or exc.code not in _CANNOT_COUNT:
                raise
            self._can_count = False
            return None

    async def retrieve(self, thing_id: str) -> bytes | None:
        """Return the description of one thing; None if the directory no longer has it."""
        where = f"{self._url}/things/{quote(thing_id, safe='')}"
        try:
            return (await self._client.get(where, accept=_TD, max_bytes=MAX_ANNOUNCEMENT_BYTES)).body
        except RefusedError as exc:
            if exc.code in {404, 410}:
                return None
            raise

    @asynccontextmanager
    async def events(self) -> AsyncIterator[EventStream]:
        """Open the stream of changes.

        Raises:
            LinkError: The directory does not answer.
            RefusedError: It does not report changes, or refuses homebot.
            WireError: Its answer is not an event stream.
        """
        async with self._client.events(f"{self._url}/events", max_bytes=MAX_ANNOUNCEMENT_BYTES) as stream:
            yield stream

    def _resolve(self, page: str, following: str) -> str:
        if not following:
            return ""
        try:
            where = URL(page).join(URL(following))
        except ValueError:
            raise WireError("the next page of the list has no address") from None
        if where.origin() != self._origin:
            raise WireError("the next page of the list is on another server")
        return str(where)
