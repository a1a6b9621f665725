"""Helpers of a house: read, set, counted, timed, kept over a restart; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from tests.apps.houses import hall

from homebot.clock import read_zone
from homebot.config import parse_config, parse_settings
from homebot.devices import Devices
from homebot.devices.command_messages import CommandDevices, CommandDevicesRequest
from homebot.devices.names import COMMAND_DEVICES
from homebot.errors import ConfigError
from homebot.features.helpers.settings import HelpersSettings
from homebot.graph import Node
from homebot.runtime import Runtime
from homebot.testing import virtual_house_of
from homebot.testing.virtual_house import VirtualHouse

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]

read_zone("UTC")  # read from the disk before any loop runs
HELPERS: dict[str, object] = {
    "vacation": False,
    "lux_limit": {"value": 30, "min": 0, "max": 100},
    "mode": ["day", "night"],
    "visits": {"counter": 0},
    "oven": {"timer": "10m"},
}
ROUTINES: list[dict[str, object]] = [
    {"name": "Visit", "when": ["hall motion occupied"], "do": ["visits number +1"]},
    {"name": "Night", "when": ["08:20"], "do": ["vacation on", "mode option night", "oven on"]},
    {"name": "Told", "when": ["name='mode' option='night'"], "if": ["vacation on"], "do": ["notify Night"]},
    {"name": "Often", "when": ["visits number above 1"], "do": ["notify Twice, {visits number}"]},
    {"name": "Oven", "when": ["oven press finished"], "do": ["notify Done"]},
    {"name": "Timers", "when": ["08:20"], "do": ["egg number 1.5", "tea on", "wait 1m", "tea off"]},
    {"name": "Early", "when": ["at text of wake up"], "do": ["notify Up at {time}", "wake up: 08:22"]},
    {"name": "Timed", "when": ["egg press finished", "tea press finished"], "do": ["notify {name} at {time}"]},
]


async def values(node: Node) -> dict[str, object]:
    names = {name.replace("_", " ") for name in HELPERS}
    return {
        device.name: device.states[0].value.plain() for device in await Devices(node).find() if device.name in names
    }


@pytest.mark.slow
async def test_routines_read_and_set_helpers_as_devices() -> None:
    world = hall(("08:01", "hall"), ("08:03", "outside"), ("08:10", "hall"))
    timers = {"egg": {"timer": "10m"}, "tea": {"timer": "90s"}, "wake_up": {"time": "08:18:30"}}
    config: dict[str, object] = {"routines": ROUTINES, "home": {"zone": "UTC"}, "notify": {}}
    config["helpers"] = HELPERS | timers
    async with virtual_house_of(world=world, config=config, start="2026-01-01 08:00") as house:
        await house.run_until("08:25")
        assert await values_of(house) == {
            "vacation": True, "lux limit": 30.0, "mode": "night", "visits": 2.0, "oven": True,
        }  # fmt: skip
        assert [one.message for one in house.notifications] == [
            "Twice, 2",
            "Up at 08:18",
            "Night",
            "egg at 08:21",
            "Up at 08:22",
        ]
        await house.run_until("08:31")
        assert (await values_of(house))["oven"] is False
        assert house.notifications[-1].message == "Done"


async def values_of(house: VirtualHouse) -> dict[str, object]:
    async with Node(house.runtime.graph, "test") as node:
        return await values(node)


@asynccontextmanager
async def homebot(folder: Path, helpers: dict[str, object]) -> AsyncIterator[Node]:
    config = parse_config({"helpers": helpers, "home": {"zone": "UTC"}}, "test")
    async with (
        Runtime(config, with_door=False, index_file=folder / "index.sqlite") as runtime,
        Node(runtime.graph, "test") as node,
    ):
        await anyio.sleep(10)
        yield node


@pytest.mark.slow
async def test_values_are_kept_over_a_restart_unless_they_are_no_longer_possible(tmp_path: Path) -> None:
    async with homebot(tmp_path, HELPERS) as node:
        commands = node.create_client(CommandDevices, COMMAND_DEVICES)
        given = {"vacation": "on", "lux limit": "number 50", "mode": "option night", "oven": "on"}
        for target, command in given.items():
            answer = await commands.call(CommandDevicesRequest(target=target, command=command))
            assert answer.success, answer.message
        assert not (await commands.call(CommandDevicesRequest(target="lux limit", command="number 101"))).success
    async with homebot(tmp_path, HELPERS | {"mode": ["day", "evening"]}) as node:
        found = await values(node)
    assert found == {"vacation": True, "lux limit": 50.0, "mode": "day", "visits": 0.0, "oven": False}


@pytest.mark.parametrize(
    ("setting", "problem"),
    [
        ({}, "give `value`"),
        ({"value": 5, "min": 10, "max": 20}, "with the value between them"),
        ({"value": 5, "counter": 1}, "give `value`"),
        ([], "a list of texts"),
        ({"timer": "0s"}, "greater than 0"),
    ],
)
def test_a_wrong_helper_is_named(setting: object, problem: str) -> None:
    with pytest.raises(ConfigError, match=problem):
        parse_settings(HelpersSettings, {"helpers": {"wrong": setting}}, "test", "helpers")
