"""The light service of the thesis, unchanged, in a house of every family of devices."""

import tomllib
from pathlib import Path

import pytest
from tests.sizes import size
from tests.whole_house import WHOLE_HOUSE

from homebot.devices import Devices
from homebot.devices.handles import Light, WindowCovering
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import READ_JOURNAL
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.house.devices import SimulatedLamp
from homebot.house.family import dialects
from homebot.house.rooms import OUTSIDE, Room, Rooms
from homebot.house.simulated_device import Placed
from homebot.testing import EventLog, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time]

MIXED = tomllib.loads((Path(__file__).parents[2] / "examples" / "houses" / "mixed.toml").read_text("utf-8"))


def hall(*lamps: Placed) -> World:
    return World(Rooms({OUTSIDE: Room(window=1.0), "hall": Room()}, []), lamps)


@pytest.mark.parametrize("dialect", dialects())
async def test_the_light_service_switches_lamps_of_every_family(dialect: str) -> None:
    """One that is lit by hand, and one that shone before anybody looked."""
    world = hall(
        Placed(SimulatedLamp("early", is_on=True), "hall", dialect=dialect),
        Placed(SimulatedLamp("late"), "hall", dialect=dialect),
    )
    async with virtual_house_of("light_service", world=world) as house:
        await house.run_for("30s")
        assert world.device("early").state() == "off"
        await house.press("late", "on")
        await house.run_for("1s")
        assert world.device("late").state() == "off"
        counters = house.simulated.counters
        assert (counters.unsaid, counters.overflowed, counters.refused) == (0, 0, 0)


@WHOLE_HOUSE
@pytest.mark.no_cover
async def test_a_day_of_a_mixed_house_loses_nothing() -> None:
    """Each lamp that was lit is dark again soon, by a command that came over the wire; nothing is lost."""
    world = parse_world(MIXED, "mixed.toml", seed=3)
    async with virtual_house_of("light_service", world=world, seed=3) as house, EventLog.of(house) as log:
        await house.run_for(f"{size(10, 24)}h")
    happened = world.event_log.since(0)
    lit = [event for event in happened if event.verb == "switch" and event.what == "on"]
    assert {world.devices[event.who].dialect for event in lit} >= {"zigbee2mqtt", "homeassistant", "tasmota"}
    for event in lit:
        answers = [one.at for one in happened if one.who == event.who and (one.verb, one.what) == ("told", "off")]
        assert any(event.at <= at <= event.at + 5.0 for at in answers), event
    supervisor, counters = house.runtime.supervisor, house.simulated.counters
    assert (supervisor.restarts, supervisor.given_up, log.lost) == ({}, [], 0)
    assert (counters.unsaid, counters.overflowed, counters.refused) == (0, 0, 0)


@pytest.mark.parametrize("dialect", dialects())
async def test_a_device_is_in_its_room_and_has_its_name_whatever_it_speaks(dialect: str) -> None:
    """Most makers' protocols carry no room, and some no name: the owner states them."""
    kinds = sorted(dialects()[dialect].kinds - {"robot", "tag"})
    devices = {f"hall_{kind}": {"kind": kind, "room": "hall", "dialect": dialect} for kind in kinds}
    world = parse_world({"rooms": {"hall": {}}, "devices": devices}, "hall.toml")
    async with virtual_house_of(world=world) as house, Node(house.runtime.graph, "judge") as judge:
        await house.run_for("20s")
        found = await Devices(judge).find()
    assert {(device.name, device.area) for device in found} == {(name, "hall") for name in devices}


@WHOLE_HOUSE
@pytest.mark.parametrize("dialect", dialects())
async def test_the_effects_of_commands_are_no_hand_whatever_a_device_speaks(dialect: str) -> None:
    """A lamp that is on again as it was, and a cover that rests where it was sent, are confirmed and explained."""
    kinds = {"lamp", "cover"} & dialects()[dialect].kinds
    devices = {kind: {"kind": kind, "room": "hall", "dialect": dialect} for kind in kinds}
    world = parse_world({"rooms": {"hall": {}}, "devices": devices}, "hall.toml")
    async with virtual_house_of(world=world) as house, Node(house.runtime.graph, "judge") as judge:
        await house.run_for("20s")
        for setting in (("on_off", True), ("level", 80.0), ("on_off", False), ("level", 80.0)):
            for lamp in await Devices(judge).find(Light):
                assert (await lamp.command(*setting)).succeeded, setting
            await house.run_for("15s")
        for position in (30, 0, 50, 100):
            for cover in await Devices(judge).find(WindowCovering):
                assert (await cover.set_position(position)).succeeded, position
            await house.run_for("15s")
        journal = await judge.create_client(ReadJournal, READ_JOURNAL).call(ReadJournalRequest())
    assert [one for one in journal.entries if one.kind == "changed"] == []
