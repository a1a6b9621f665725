"""Persons at switches, within seconds of commands and after lost connections: neither overridden nor blamed."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, ignore, obey, report

from homebot.devices.handles import Handle, Light, OccupancySensor
from homebot.devices.outcomes import AlreadySo, Confirmed, Evidence, NoAnswer

pytestmark = pytest.mark.virtual_time


async def test_a_command_after_a_lost_connection_is_sent(home: Home) -> None:
    """The lamp may have been switched off meanwhile."""
    lamp = await home.lamp("on_off", before={"on_off": True})
    await anyio.sleep(1)
    home.gateway.set_unavailable("the cable is out")
    await anyio.sleep(10)
    home.gateway.set_available()
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_on(), Confirmed)
    assert len(home.commands) == 1


async def test_silence_after_a_lost_connection_does_not_prove_that_it_is_so_still(home: Home) -> None:
    """It may be dead; one that is online by its last will reports only changes."""
    for name in ("lamp", "relay"):
        home.put(name, "light", "on_off")
        home.behaviours[name] = ignore
        await home.report(name, "on_off", True)
    home.gateway.set_unavailable("the cable is out")
    await anyio.sleep(10)
    home.gateway.set_available()
    home.gateway.devices.report_reachable("relay", reachable=True)
    await anyio.sleep(1)
    outcomes = {one.name: await one.turn_on() for one in await home.devices.find(Light)}
    assert {name: type(outcome) for name, outcome in outcomes.items()} == {"Lamp": NoAnswer, "Relay": AlreadySo}


async def test_a_report_after_a_lost_connection_is_recent(home: Home) -> None:
    lamp = await home.lamp("on_off")
    home.gateway.set_unavailable("the cable is out")
    await anyio.sleep(10)
    home.gateway.set_available()
    await home.report("lamp", "on_off", True)
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_on(), AlreadySo)
    assert home.commands == []


async def test_a_paused_vacuum_is_stopped(home: Home) -> None:
    """A pause goes on by itself, a stop does not."""
    robby = await home.new(
        Handle,
        "robby",
        "vacuum",
        service_type="robotic_vacuum_cleaner",
        before={"vacuum": "paused"},
        behaviour=report((0.5, "idle")),
    )
    assert isinstance(await robby.command("vacuum", "idle"), Confirmed)
    assert [one.value.plain() for one in home.commands] == ["idle"]


async def test_a_person_who_rejects_commands_is_not_overridden(home: Home) -> None:
    """Each time "off" 1.5 s after "on"."""
    lamp = await home.lamp("on_off", behaviour=report((0.05, True), (1.55, False)))
    for _ in range(5):
        home.commands.clear()
        await lamp.turn_on()
        await anyio.sleep(60)
        assert len(home.commands) == 1


async def test_a_lamp_is_as_honest_as_before_after_a_person_rejected_two_commands(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=report((0.05, True), (1.55, False)))
    for _ in range(2):
        await lamp.turn_on()
        await anyio.sleep(60)
    home.behaviours["lamp"] = obey
    for number in range(15):
        outcome = await (lamp.turn_off() if number % 2 else lamp.turn_on())
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED
        await anyio.sleep(30)


async def press(home: Home, lamp: Light, delay: float = 0.0) -> list[str]:
    """Press the remote, to which an app answers with "off"; return the outcomes."""
    outcomes: list[str] = []

    async def run_app() -> None:
        async for change in home.devices.follow(Handle):
            if change.kind == "event":
                await anyio.sleep(delay)
                outcomes.append(type(await lamp.turn_off()).__name__)

    home.tasks.start_soon(run_app)
    await anyio.sleep(1)
    await home.report("remote", "press", "single")
    await anyio.sleep(delay + 1)
    return outcomes


@pytest.mark.parametrize(("delay", "expected"), [(0.0, "Confirmed"), (120.0, "Refused")])
async def test_a_press_of_the_wall_remote_turns_off_the_light_of_an_occupied_room(
    open_home: OpenHome, delay: float, expected: str
) -> None:
    """Two minutes later it is the app that wants it."""
    async with open_home(presence_guard=True) as home:
        home.put("lamp", "light", "on_off", area="Hall")
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        home.put("remote", "generic_switch", readable=("press",), area="hall")
        await home.report("lamp", "on_off", True)
        await home.report("motion", "occupancy", True)
        lamp = await home.handle(Light, "lamp")
        assert await press(home, lamp, delay) == [expected]


async def test_a_report_of_a_motion_sensor_is_no_wish_of_a_person(open_home: OpenHome) -> None:
    async with open_home(presence_guard=True) as home:
        home.put("lamp", "light", "on_off", area="Hall")
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        lamp = await home.handle(Light, "lamp")
        outcomes: list[str] = []

        async def run_app() -> None:
            async for change in home.devices.follow(OccupancySensor, occupied=True):
                assert change.kind == "appeared"
                outcomes.append(type(await lamp.turn_off()).__name__)

        home.tasks.start_soon(run_app)
        await anyio.sleep(1)
        await home.report("motion", "occupancy", True)
        await anyio.sleep(1)
        assert outcomes == ["Refused"]


async def test_a_motion_sensor_that_was_away_does_not_prove_that_nobody_came_meanwhile(open_home: OpenHome) -> None:
    """It reports the same value as before, and what it reported while it was away was lost."""
    async with open_home(presence_guard={"absent_after": 300.0}) as home:
        home.put("lamp", "light", "on_off", area="Hall")
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        await home.report("lamp", "on_off", True)
        for value in (True, False):
            await home.report("motion", "occupancy", value)
            await anyio.sleep(600)
        home.gateway.devices.report_reachable("motion", reachable=False)
        await anyio.sleep(600)
        home.gateway.devices.report_reachable("motion", reachable=True)
        await home.report("motion", "occupancy", False)
        lamp = await home.handle(Light, "lamp")
        await anyio.sleep(60)
        assert "motion has been heard for only 60 s" in (await lamp.turn_off()).text
        await anyio.sleep(300)
        assert isinstance(await lamp.turn_off(), Confirmed)
