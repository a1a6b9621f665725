"""Warnings for queries of apps with a type, an area or a tag that is likely misspelt."""

from __future__ import annotations

from typing import Final, final

import anyio

from homebot.devices.configured_names import ANNOUNCED_WITHIN
from homebot.devices.names import QUERY_DEVICES
from homebot.devices.query import Query, TypeIs, query_terms
from homebot.devices.query.vocabulary import TYPE_WORDS
from homebot.devices.services import QueryDevices, QueryDevicesRequest
from homebot.errors import ServiceError
from homebot.graph import Node
from homebot.support.folding import is_typo

__all__ = ["QueryCheck"]

UNKNOWN: Final = "devices.unknown_word"
_SOON: Final = 10.0
_MOST: Final = 100


@final
class QueryCheck:
    """Log of the misspelt queries of a node, each once.

    Args:
        node: The node that asks the directory.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        self._logged: set[str] = set()

    async def check(self, query: Query, text: str) -> None:
        """Log the words of *query*, in the app *text*, that the directory does not know; a failed call logs nothing."""
        if text in self._logged or len(self._logged) >= _MOST:
            return
        try:
            answer = await self._query.call(QueryDevicesRequest(query=query_terms(query), limit=1))
        except ServiceError:
            return
        if not answer.success and text not in self._logged:
            self._logged.add(text)
            self._node.log.warning(UNKNOWN, message=f"{text}: {answer.message}")

    def check_later(self, query: Query, text: str) -> None:
        """Do so soon, and when devices had time to be announced; of a type that may yet be announced only then."""

        async def check() -> None:
            await anyio.sleep(_SOON)
            if not isinstance(query, TypeIs) or any(is_typo(query.word, one) for one in TYPE_WORDS):
                await self.check(query, text)
            await anyio.sleep(ANNOUNCED_WITHIN - _SOON)
            await self.check(query, text)

        self._node.create_task(check)
