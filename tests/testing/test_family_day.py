"""A day of the family home with the light service of the thesis, in virtual time: what holds for every seed.

``HOUSES`` in the environment is the number of seeds: one while coverage is measured, which takes five times as long;
``make houses`` takes 100.
"""

import os
import tomllib
from collections import Counter
from pathlib import Path

import pytest
from tests.thesis_light_service import THESIS_LIGHT_SERVICE
from tests.whole_house import WHOLE_HOUSE

from homebot.devices import Devices
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.house.event_log import Event
from homebot.house.rooms import DAY
from homebot.testing import EventLog, VirtualHouse, virtual_house_of

pytestmark = WHOLE_HOUSE

FAMILY = tomllib.loads((Path(__file__).parents[2] / "examples" / "houses" / "family.toml").read_text("utf-8"))
HOUSES = int(os.environ.get("HOUSES", "1"))
ROOT = "home425"

Line = tuple[float, str, str]
"""When, in seconds since midnight; topic without the home; payload."""


@pytest.mark.no_cover
@pytest.mark.parametrize("seed", range(HOUSES))
@pytest.mark.virtual_time
async def test_a_day_of_the_family_home_holds_what_it_promises(seed: int) -> None:
    """Faults there are in the house, not on the wire: so all that is said is heard, and all that is told is obeyed."""
    world = parse_world(FAMILY, "family.toml", seed=seed)
    async with (
        virtual_house_of(THESIS_LIGHT_SERVICE, world=world, seed=seed) as house,
        EventLog.of(house) as log,
        Node(house.runtime.graph, "judge") as judge,
    ):
        midnight = house.clock.now()
        await house.run_for("1d")
        found = await Devices(judge).find()
    lines = [
        (round(event.at - midnight, 3), event.name.removeprefix(f"{ROOT}/"), event.text)
        for event in log.events
        if event.source == "mqtt"
    ]
    happened = world.event_log.since(0)
    assert_light_service_answered(lines)
    assert_wire_says_what_the_world_says(lines, happened, world)
    assert_commands_arrived(lines, happened)
    assert {device.id for device in found} == {_key(world, name) for name in world.devices}
    assert {device.freshness for device in found} == {"fresh"}
    assert_nothing_was_lost(house, log, world)


def assert_light_service_answered(lines: list[Line]) -> None:
    """Each report of a lamp that it shines, at once and with one ``off``; nobody was told anything else."""
    told = Counter((at, topic.removesuffix("/in"), text) for at, topic, text in lines if topic.endswith("/in"))
    shone = [(at, topic, text) for at, topic, text in lines if topic.startswith("lights/") and _shines(text)]
    assert len(shone) > 20
    assert told == Counter((at, topic.removesuffix("/out"), "off") for at, topic, _ in shone)


def _shines(word: str) -> bool:
    try:
        return word == "on" or float(word) > 0
    except ValueError:
        return False


def assert_wire_says_what_the_world_says(lines: list[Line], happened: tuple[Event, ...], world: World) -> None:
    """Each word of each device at its time and in its order; besides these only the last word, again."""
    for name in world.devices:
        topic = f"{_key(world, name)}/out"
        words = [(event.at, event.what) for event in happened if event.who == name and event.verb == "says"]
        heard = [(at, text) for at, where, text in lines if where == topic]
        assert len(heard) >= DAY / 300.0 - 1
        due = iter(words)
        coming = next(due, None)
        last = heard[0][1]  # how it was at midnight
        for at, text in heard:
            if coming is not None and text == coming[1] and abs(at - coming[0]) < 0.002:  # the log has milliseconds
                last, coming = text, next(due, None)
            else:
                assert text == last, f"{name} says {text} at {at} after {last}, before {coming}"
        assert coming is None, f"{name} was not heard saying {coming}"


def assert_commands_arrived(lines: list[Line], happened: tuple[Event, ...]) -> None:
    """All by radio, in the world at the time of the wire; besides these only the errands of the house."""
    told = Counter((round(event.at, 3), event.who, event.what) for event in happened if event.verb == "told")
    sent = Counter((at, topic.split("/")[1], text) for at, topic, text in lines if topic.endswith("/in"))
    errands = told - sent
    assert not sent - told
    assert errands.total() == len(FAMILY["errands"])


def assert_nothing_was_lost(house: VirtualHouse, log: EventLog, world: World) -> None:
    """Nobody crashed, and no buffer ran over."""
    supervisor = house.runtime.supervisor
    assert (supervisor.restarts, supervisor.given_up) == ({}, [])
    counters = house.simulated.counters
    assert (counters.unsaid, counters.overflowed, counters.refused) == (0, 0, 0)
    stats = house.broker.stats
    assert (stats.connections_refused, stats.connections_failed, stats.dropped_qos0, stats.dropped_offline) == (0,) * 4
    assert (stats.dropped_overrun, stats.dropped_expired, stats.dropped_refused, stats.queued_messages) == (0,) * 4
    assert (log.lost, world.event_log.dropped) == (0, 0)


def _key(world: World, name: str) -> str:
    return f"{world.devices[name].device.service_type}/{name}"
