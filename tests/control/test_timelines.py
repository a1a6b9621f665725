"""How much the timelines of a whole house keep."""

import gc
from collections import Counter

import anyio
import pytest
from tests.control.conftest import Home
from tests.recorded_house import device, part

from homebot.control import durations
from homebot.control.gateway_feed import GatewayFeed
from homebot.control.learnt import LearntPersistence
from homebot.control.timeline.facts import Decided, Order, Reported, Sent
from homebot.control.timeline.progress import CommandProgress
from homebot.control.timelines import Timelines
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Evidence
from homebot.graph import Graph, Node
from homebot.journal.store import JournalStore

pytestmark = pytest.mark.virtual_time

FACTS = CommandProgress, Reported, Sent


async def test_what_a_command_left_goes_although_its_part_is_never_commanded_again(home: Home) -> None:
    """Each of 2,400 commands to 40 switches kept 5 KiB for as long as homebot ran."""
    lamps = [await home.new(Light, f"lamp {number}", "on_off") for number in range(5)]
    for lamp in lamps:
        for number in range(4):
            assert isinstance(await lamp.command("on_off", number % 2 == 0), Confirmed)
    await anyio.sleep(durations.COUNTED + durations.FORGOTTEN_EVERY)
    gc.collect()
    left = Counter(type(one) for one in gc.get_objects() if type(one) in FACTS)
    assert (left[CommandProgress], left[Sent]) == (0, 0)
    assert left[Reported] == len(lamps)  # the newest
    assert isinstance(await lamps[0].command("on_off", value=True), Confirmed)


async def test_all_timelines_together_keep_a_limited_number_of_commands_and_count_the_others() -> None:
    async with Node(Graph(), "control") as node:
        timelines = Timelines(node, GatewayFeed(node), LearntPersistence(node, JournalStore(10, 60.0)), 10.0, 10.0)
        house = [device(f"lamp {number}", part("light", "on_off")) for number in range(100)]
        for number in range(8_000):
            lamp = house[number % len(house)]
            timeline, name, at = timelines.of(lamp, lamp.parts[0]), f"c-{number}", number / 100
            timeline.command(Order(name, {"on_off": True}, {}, place=(lamp.id, "")), at)
            timeline.append(Decided(name, at, Confirmed(0.1, Evidence.REPORTED)))
        kept = [one.order.id for lamp in house for one in timelines.of(lamp, lamp.parts[0]).commands]
    assert 4_000 <= len(kept) <= 5_000
    assert timelines.forgotten == 8_000 - len(kept)
    assert set(kept) == {f"c-{number}" for number in range(8_000 - len(kept), 8_000)}  # the newest
