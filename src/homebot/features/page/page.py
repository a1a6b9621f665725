"""The services of the page's own data."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from functools import cache, partial
from importlib import import_module
from typing import TYPE_CHECKING, Final, Protocol, final

import anyio

from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES, LIST_DEVICES
from homebot.devices.services import ListDevices, ListDevicesRequest
from homebot.errors import RefusedError, UsageError, WireError
from homebot.features.page import CHANGE_LAYOUT, FEATURE, GET_USAGE, LAYOUT, SETUP
from homebot.features.page.layout import LayoutBook, change_layout, read_book
from homebot.features.page.messages import (
    ChangeLayout,
    ChangeLayoutRequest,
    ChangeLayoutResponse,
    GetUsage,
    PageLayout,
    UsageRequest,
    UsageResponse,
)
from homebot.features.page.pictures import Pictures
from homebot.features.page.usage import Usage
from homebot.graph import Node, qos_profile_latched
from homebot.support.isolation import run_as

if TYPE_CHECKING:
    from pathlib import Path

    from homebot.feature_context import FeatureContext
    from homebot.features.page.setup import Setup

UNREADABLE: Final = "page.unreadable"

_ENTRIES: Final = 1000
"""Journal entries that wait; the oldest of more are lost, and not counted."""


class RecordKeeper(Protocol):
    """Keeps a record of the owner across restarts, as the directory does."""

    def owner_record(self, feature: str) -> str:
        """Return the record that was kept; empty for none."""

    async def save_record(self, feature: str, record: str, *, at_once: bool) -> str:
        """Save *record*; return why that failed, in words, empty if it did not."""


async def serve_page(house: FeatureContext) -> None:
    """Serve the page's data until cancelled."""
    async with Node(house.graph, FEATURE.name) as node:
        usage = Usage(house.store("page usage"), house.zone)
        offer_setup(node, house.config_file, house.restart)
        Pictures(node, house.table("pictures") or {}).offer()
        await run_as(node.full_name, PageData(node, usage, house.directory).serve)


def offer_setup(
    node: Node,
    file: Callable[[], Path | None],
    restart: Callable[[], None] | None = None,
    listens: Callable[[int], Awaitable[bool]] | None = None,
) -> None:
    """Offer the services of the setup, which is loaded with the first call."""

    @cache
    def setup() -> Setup:
        from homebot.features.page.setup import Setup  # noqa: PLC0415 - few runs are set up

        return Setup(node, file, restart, listens)

    for service in SETUP:
        start = partial(lambda name: setup().serve(name), service.name)
        load = partial(import_module, "homebot.features.page.setup")
        node.offer_service(service.ros_type, service.name, start, load)


@final
class PageData:
    """The layout of the owner, which all screens follow, and the use of devices.

    Args:
        keeper: Returns the keeper of the layout; None before it runs.
    """

    def __init__(self, node: Node, usage: Usage, keeper: Callable[[], RecordKeeper | None]) -> None:
        self._node = node
        self._usage = usage
        self._keeper = keeper
        self._book = LayoutBook()

    async def serve(self) -> None:
        """Serve until cancelled."""
        node = self._node
        await node.create_client(ListDevices, LIST_DEVICES).call(ListDevicesRequest(limit=1))  # its file is read then
        if (keeper := self._keeper()) is not None:
            try:
                self._book = read_book(keeper.owner_record(FEATURE.name))
            except WireError as exc:
                node.log.error(UNREADABLE, message=f"the order of the page cannot be read, and begins anew: {exc}")
        self._layout = node.create_publisher(PageLayout, LAYOUT, qos_profile_latched)
        self._layout.publish(self._book.layout)
        node.create_subscription(JournalEntry, JOURNAL_ENTRIES, self._usage.add, _ENTRIES)
        node.create_service(ChangeLayout, CHANGE_LAYOUT.name, self._change)
        node.create_service(GetUsage, GET_USAGE.name, self._answer_usage)
        await anyio.sleep_forever()

    async def _change(self, request: ChangeLayoutRequest) -> ChangeLayoutResponse:
        try:
            book = change_layout(self._book, request)
        except (UsageError, RefusedError) as exc:
            return ChangeLayoutResponse(success=False, message=str(exc), layout=self._book.layout)
        problem = ""
        if book != self._book:
            self._book = book
            self._layout.publish(book.layout)
            keeper = self._keeper()
            if keeper is not None:
                problem = await keeper.save_record(FEATURE.name, book.model_dump_json(), at_once=True)
        message = f"a restart would lose this, as it was not written: {problem}" if problem else ""
        return ChangeLayoutResponse(success=True, message=message, layout=book.layout)

    def _answer_usage(self, _: UsageRequest) -> UsageResponse:
        return self._usage.answer(self._node.graph.clock.now())
