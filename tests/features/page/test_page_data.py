"""The order of the page and the use of devices are the same for all screens; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime
from typing import Any, NamedTuple

import anyio
import pytest
from tests.discovery.directory_house import directory

from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.devices.trigger import Trigger
from homebot.features.page.messages import (
    ChangeLayout,
    ChangeLayoutRequest,
    ChangeLayoutResponse,
    GetUsage,
    PageLayout,
    UsageRequest,
    UsageResponse,
)
from homebot.features.page.page import PageData
from homebot.features.page.usage import Usage
from homebot.graph import Node, Publisher, Subscription, qos_profile_latched
from homebot.messages import Time
from homebot.messages.json import message_from_json

pytestmark = pytest.mark.virtual_time


class Kept:
    """Keeps the layout where a restart finds it."""

    def __init__(self) -> None:
        self.record = ""
        self.problem = ""

    def owner_record(self, feature: str) -> str:
        assert feature == "page"
        return self.record

    async def save_record(self, feature: str, record: str, *, at_once: bool) -> str:
        assert (feature, at_once) == ("page", True)
        self.record = record
        return self.problem


class Screen(NamedTuple):
    """A client of the page's data."""

    node: Node
    shown: Subscription[PageLayout]
    entries: Publisher[JournalEntry]

    async def change(self, change: str, *names: str, **more: str) -> ChangeLayoutResponse:
        request = message_from_json(ChangeLayoutRequest, {"change": change, "names": names, **more})
        return await self.node.create_client(ChangeLayout, "/page/change_layout").call(request)

    async def usage(self) -> UsageResponse:
        await anyio.sleep(0.01)
        return await self.node.create_client(GetUsage, "/page/usage").call(UsageRequest())


@asynccontextmanager
async def screen(kept: Kept, days: dict[str, Any] | None = None) -> AsyncIterator[Screen]:
    async with (
        directory() as house,
        Node(house.asker.graph, "page") as node,
        Node(house.asker.graph, "screen") as client,
        anyio.create_task_group() as tasks,
    ):
        tasks.start_soon(PageData(node, Usage({} if days is None else days, UTC), lambda: kept).serve)
        shown = client.create_subscription(PageLayout, "/page/layout", None, qos_profile_latched)
        entries = client.create_publisher(JournalEntry, JOURNAL_ENTRIES, 1000)
        await anyio.sleep(0.1)
        yield Screen(client, shown, entries)
        tasks.cancel_scope.cancel()


async def test_a_star_an_order_and_an_icon_are_seen_by_all_screens_and_outlive_a_restart() -> None:
    kept = Kept()
    async with screen(kept) as wall:
        assert wall.shown.take() == PageLayout()
        assert (await wall.change("add", "hall_lamp", "desk_lamp")).success
        await wall.change("add", "desk_lamp", "tv")
        await wall.change("order", "tv", "hall_lamp")
        await wall.change("icon", "room:Kitchen", icon="stove")
        await wall.change("order", "Kitchen", "Hall", list="rooms")
        answer = await wall.change("add", "room:Attic", list="hidden")
        shown = [layout async for layout in drained(wall.shown)]
        assert shown[-1] == answer.layout
    async with screen(kept) as phone:
        layout = phone.shown.take()
        assert layout is not None
        assert layout.favorites == ("tv", "hall_lamp", "desk_lamp")
        assert layout.rooms == ("Kitchen", "Hall")
        assert layout.hidden == ("room:Attic",)
        assert [(icon.key, icon.value) for icon in layout.icons] == [("room:Kitchen", "stove")]
        assert layout.undoes == "add hidden: room:Attic"


async def test_the_last_change_is_undone_and_the_undo_too() -> None:
    async with screen(Kept()) as wall:
        assert not (await wall.change("undo")).success
        await wall.change("add", "lamp")
        await wall.change("remove", "lamp")
        assert (await wall.change("undo")).layout.favorites == ("lamp",)
        assert (await wall.change("undo")).layout.favorites == ()


async def test_a_wrong_change_changes_nothing_and_says_why() -> None:
    kept = Kept()
    async with screen(kept) as wall:
        for names, why in (
            ((), "has no names"),
            (("a\nb",), "cannot be a name"),
            (tuple(f"lamp{number}" for number in range(500)), ""),
            (("one_more",), "there may be 500"),
        ):
            answer = await wall.change("add", *names)
            assert answer.success is not bool(why)
            assert why in answer.message
        kept.problem = "the disk is full"
        assert "not written: the disk is full" in (await wall.change("remove", "lamp1")).message


async def test_an_unreadable_order_begins_anew() -> None:
    kept = Kept()
    kept.record = '{"layout": 7}'
    async with screen(kept) as wall:
        assert (await wall.change("add", "lamp")).layout.favorites == ("lamp",)


def command(device: str, at: str, issuer: str = "client:wall", **more: Any) -> JournalEntry:
    moment = Time.from_seconds(datetime.fromisoformat(f"{at}:00+00:00").timestamp())
    return JournalEntry(**{"kind": "requested", "at": moment, "device": device, "issuer": issuer, **more})


async def test_commands_of_people_are_counted_by_device_and_hour_for_28_days() -> None:
    days: dict[str, Any] = {"1969-12-01": {"old": {"7": 5}}, "1969-12-30": {"tv": {"20": 2}}}
    async with screen(Kept(), days) as wall:
        for entry in (
            command("lamp", "1970-01-01T07:10"),
            command("lamp", "1970-01-01T07:50"),
            command("lamp", "1970-01-01T19:00"),
            command("heater", "1970-01-01T07:00", "/apps/morning"),
            command("heater", "1970-01-01T07:00", trigger=Trigger(kind="program")),
            command("heater", "1970-01-01T07:00", trigger=Trigger(scene="Movie")),
            command("heater", "1970-01-01T07:00", kind="sent"),
        ):
            wall.entries.publish(entry)
        usage = await wall.usage()
        counts = {row.device: {hour: count for hour, count in enumerate(row.hours) if count} for row in usage.devices}
        assert counts == {"lamp": {7: 2, 19: 1}, "tv": {20: 2}}
        assert [row.device for row in usage.devices] == ["lamp", "tv"]
        assert "1969-12-01" not in days

        for number in range(600):
            wall.entries.publish(command(f"lamp{number}", "1970-01-01T08:00"))
        usage = await wall.usage()
        assert (len(usage.devices), usage.lost) == (500, 101)


async def drained(subscription: Subscription[PageLayout]) -> AsyncIterator[PageLayout]:
    while (message := subscription.take()) is not None:
        yield message
