"""Rooms, tags, types and names in the queries of an app that nothing in the house has.

A device with that name may still come, so they are warnings, in the log and in ``homebot doctor``, and no errors.
"""

from collections.abc import Iterator
from functools import cached_property, partial
from typing import Final, final

import anyio

from homebot.devices.names import QUERY_DEVICES
from homebot.devices.query.term_messages import query_terms
from homebot.devices.query.terms import And, AreaIs, FactIs, HasText, InArea, NameIs, Not, Query, TypeIs, leaves
from homebot.devices.services import QueryDevices, QueryDevicesRequest, QueryDevicesResponse
from homebot.errors import ServiceError
from homebot.graph import Client, Node

UNKNOWN_NAME: Final = "devices.unknown_name"
NOTHING_FITS: Final = "devices.nothing_fits"

_CHECKED_AFTER: Final = (10.0, 290.0)
"""Seconds until the names in a query are checked, and then until the second check."""

_MAX_DEVICES: Final = 100
_NO_TYPE: Final = "nothing in the house is of this type"
_NAMES: Final = (TypeIs, AreaIs, InArea, FactIs, NameIs, HasText)


@final
class NameChecks:
    """Checks of the names in the first 100 queries of one node, each by the text of its call.

    Attributes:
        unknown: The problem of each query whose names nothing in the house had when it was last checked.
    """

    def __init__(self, node: Node) -> None:
        self.unknown: dict[str, str] = {}
        self._node = node
        self._queries: dict[str, Query] = {}
        self._checked_at = 0.0

    def add(self, query: Query, text: str) -> None:
        """Check *query* soon, and after devices had time to be announced."""
        if text not in self._queries and len(self._queries) < _MAX_DEVICES:
            self._queries[text] = query
            self._checked_at = anyio.current_time() + _CHECKED_AFTER[0]
            self._node.create_task(partial(self._check_later, query, text))

    def remove(self, text: str) -> None:
        """End the checks of a query; idempotent."""
        self._queries.pop(text, None)
        self.unknown.pop(text, None)

    async def finish(self) -> tuple[str, ...]:
        """Return the problems once each query so far has been checked."""
        if self._queries:
            await anyio.sleep_until(self._checked_at)
            for text in tuple(self._queries):
                await self._check(text)
        return tuple(self.unknown.values())

    async def problems(self) -> tuple[str, ...]:
        """Return the problems that are not solved by now."""
        for text in tuple(self.unknown):
            await self._check(text)
        return tuple(self.unknown.values())

    async def mistakes(self) -> tuple[str, ...]:
        """Return the problem of each query with an unknown name, also of those that are not checked yet."""
        looked = [(text, await self._look(query)) for text, query in tuple(self._queries.items())]
        return tuple(f"{text}: {mistake}" for text, (_, mistake) in looked if mistake)

    async def _check_later(self, query: Query, text: str) -> None:
        is_found = True
        for wait in _CHECKED_AFTER:
            await anyio.sleep(wait)
            is_found = await self._check(text)
        if not is_found and _is_of_names(query):
            minutes = sum(_CHECKED_AFTER) / 60
            self._report(text, f"nothing in the house has all of these, {minutes:g} minutes on", NOTHING_FITS)

    async def _check(self, text: str) -> bool:
        """Return whether something in the house fits a query, also if it has ended; report an unknown name."""
        query = self._queries.get(text)
        is_found, mistake = (True, "") if query is None else await self._look(query)
        if is_found:
            self.unknown.pop(text, None)
        elif mistake:
            self._report(
                text,
                f"{mistake}{'' if mistake.endswith('?') else '.'} Until a device comes, it finds nothing.",
                UNKNOWN_NAME,
            )
        return is_found

    def _report(self, text: str, problem: str, event: str) -> None:
        if text in self._queries and text not in self.unknown:
            self.unknown[text] = f"{text}: {problem}"
            self._node.log.warning(event, message=self.unknown[text])

    @cached_property
    def _client(self) -> Client[QueryDevicesRequest, QueryDevicesResponse]:
        return self._node.create_client(QueryDevices, QUERY_DEVICES)

    async def _look(self, query: Query) -> tuple[bool, str]:
        """Return whether something fits *query*, also if nobody answers, and which name in it nothing has, if any."""
        try:
            answer = await self._ask(query)
            if answer.total or answer.is_mistake:
                return answer.success and answer.total > 0, answer.message if answer.is_mistake else ""
            for term in filter(_is_of_names, _required(query)):
                answer = await self._ask(term)
                if not answer.total:
                    none = f"no device has the word {term.text!r}" if isinstance(term, HasText) else _NO_TYPE
                    return False, answer.message or none
        except ServiceError:
            return True, ""
        return False, ""

    async def _ask(self, query: Query) -> QueryDevicesResponse:
        return await self._client.call(QueryDevicesRequest(query=query_terms(query), limit=1, is_spelled=True))


def _required(query: Query) -> Iterator[Query]:
    """Yield the terms that all must match."""
    for term in query.terms if isinstance(query, And) else (query,):
        yield from _required(term) if isinstance(term, And) else (term,)


def _is_of_names(query: Query) -> bool:
    """Return whether the query has only types, rooms, tags and names, which do not come and go."""
    return not isinstance(query, Not) and all(isinstance(term, _NAMES) for term in leaves(query))
