"""The light service in simulated houses, in virtual time: it turns off what is on, and tells what became of it."""

import re

import anyio
import pytest
from structlog.testing import capture_logs
from tests.apps.houses import flat, is_on, lamp, motion
from tests.control.conftest import OpenHome, ignore, obey, report

from homebot.apps import NoSettings
from homebot.apps.light_service import LightService
from homebot.devices.handles import Light
from homebot.graph import Node
from homebot.house import SimulatedLamp, World
from homebot.testing import virtual_house_of

pytestmark = pytest.mark.virtual_time

EVENTS = ("control.command", "app.command_failed")


async def told(world: World, command: str = "", *, wait: str = "1s") -> tuple[list[str], list[str]]:
    """Return what the lamp was told, and what the service logged of it, once hands gave *command*."""
    with capture_logs() as lines:
        async with virtual_house_of("light_service", world=world) as house:
            if command:
                await house.press("lamp", command)
            await house.run_for(wait)
    commands = [event.what for event in world.event_log.since(0) if event.verb == "told"]
    return commands, [re.sub(r"[\d.]+ s \(", "", line["message"]) for line in lines if line["event"].startswith(EVENTS)]


@pytest.mark.parametrize("command", ["on", "0.6", "0.01"])
async def test_a_lamp_that_is_on_is_turned_off_and_a_dimmed_one_too(command: str) -> None:
    commands, messages = await told(World.of(SimulatedLamp("lamp")), command)
    assert commands == ["off"]
    assert messages == ["lights/lamp → off, by light_service: confirmed after reported)"]


@pytest.mark.parametrize("command", ["off", "0", "4000 K"])
async def test_one_that_is_off_is_left_alone(command: str) -> None:
    commands, messages = await told(World.of(SimulatedLamp("lamp")), command)
    assert (commands, messages) == ([], [])


async def test_a_lamp_that_was_on_before_is_turned_off() -> None:
    world = World.of(SimulatedLamp("lamp", is_on=True))
    assert await told(world) == (["off"], ["lights/lamp → off, by light_service: confirmed after reported)"])


@pytest.mark.rooms("homeassistant")
async def test_a_lamp_that_does_not_obey_is_told_about_and_turned_off_again_some_minutes_later() -> None:
    commands, messages = await told(flat(lamp=lamp("hall", faults={"deaf": {}})), "on", wait="11m")
    assert commands == ["off"] * 9  # three tries, one as it may be fading, three; again where a heartbeat says on
    refused = [one for one in messages if "→ off, by light_service: no answer within" in one]
    assert len(refused) == 3


@pytest.mark.rooms("homeassistant")
async def test_where_somebody_is_a_policy_keeps_the_light_on() -> None:
    world = flat(("06:00", "hall"), hall_lamp=lamp("hall"), hall_motion=motion("hall"))
    with capture_logs() as lines:
        async with virtual_house_of(
            "light_service", world=world, config={"control": {"presence_guard": True}}
        ) as house:
            await house.run_until("06:01")
            await house.press("hall_lamp", "on")
            await house.run_for("30s")
    assert is_on(world, "hall_lamp")
    (message,) = [line["message"] for line in lines if line["event"] == "control.command"]
    assert message.startswith("hall_lamp → off, by light_service: refused (presence_guard): somebody is in hall")


async def test_each_time_that_a_lamp_says_on_is_answered_also_where_it_says_nothing_else(open_home: OpenHome) -> None:
    async with open_home() as home, Node(home.graph, "light_service") as node:
        home.behaviours["lamp"] = ignore
        home.tasks.start_soon(LightService(node, NoSettings()).serve)
        home.put("lamp", "light", "on_off")
        for number in range(10):
            await home.report("lamp", "on_off", True)
            await anyio.sleep(0.1)
            assert [one.value.plain() for one in home.commands] == [False] * (number + 1)
        await anyio.sleep(60)
        for number in range(10, 20):  # long after the last command has failed
            await home.report("lamp", "on_off", True)
            await anyio.sleep(0.1)
            assert len(home.commands) >= number + 1


@pytest.mark.parametrize("later", [0.0, 0.001, 0.1])
async def test_one_that_is_turned_on_again_at_once_is_turned_off_again(open_home: OpenHome, later: float) -> None:
    async with open_home() as home, Node(home.graph, "light_service") as node:
        home.behaviours["lamp"] = report((0.5, False), (0.5 + later, True))
        home.tasks.start_soon(LightService(node, NoSettings()).serve)
        home.put("lamp", "light", "on_off")
        await home.report("lamp", "on_off", True)
        await anyio.sleep(0.8)
        home.behaviours["lamp"] = obey
        await anyio.sleep(5)
        assert len(home.commands) >= 2
        assert (await home.handle(Light)).on is False


async def test_a_lamp_without_a_switch_is_turned_off_by_its_brightness(open_home: OpenHome) -> None:
    async with open_home() as home, Node(home.graph, "light_service") as node:
        home.tasks.start_soon(LightService(node, NoSettings()).serve)
        home.put("lamp", "light", "level")
        await home.report("lamp", "level", 40.0)
        await anyio.sleep(1)
        assert [(one.capability, one.value.plain()) for one in home.commands] == [("level", 0.0)]


async def test_a_lamp_that_takes_no_commands_is_told_about_and_the_others_are_served(open_home: OpenHome) -> None:
    async with open_home() as home, Node(home.graph, "light_service") as node:
        home.tasks.start_soon(LightService(node, NoSettings()).serve)
        home.put("sealed", "light", readable=("on_off",))
        home.put("lamp", "light", "on_off")
        with capture_logs() as lines:
            await home.report("sealed", "on_off", True)
            await home.report("lamp", "on_off", True)
            await anyio.sleep(1)
        assert [one.key for one in home.commands] == ["lamp"]
        messages = [line["message"] for line in lines if line["event"] == "app.command_failed"]
        assert len(messages) == 1
        assert messages[0].startswith("Sealed: ")
