"""Programs past homebot: they are learnt by their regular changes, outrank apps, and are no person; in virtual time."""

from collections.abc import Awaitable, Callable

import anyio
import pytest
from tests.control.conftest import Home, OpenHome
from tests.control.test_explanations import explain

from homebot.devices.handles import Light, Thermostat
from homebot.devices.outcomes import Refused
from homebot.devices.wording.journal_words import finding_text

pytestmark = pytest.mark.virtual_time

HOUR = 3600.0


async def put_lamp(home: Home) -> None:
    """Put a lit lamp in an empty hall with a motion sensor that has seen somebody, an hour ago."""
    home.put("lamp", "light", "on_off", "level", "color_temperature", area="hall")
    home.put("motion", "occupancy_sensor", readable=("occupancy",), area="hall")
    for key, capability, value in (("lamp", "on_off", True), ("lamp", "level", 80.0), ("motion", "occupancy", True)):
        await home.report(key, capability, value)
    await home.report("lamp", "color_temperature", 4000.0)
    await home.handle(Light, "lamp")
    await anyio.sleep(1.0)
    await home.report("motion", "occupancy", False)
    await anyio.sleep(HOUR)


async def causes(home: Home) -> list[str]:
    await anyio.sleep(1.0)
    return [one.cause for one in (await home.read()).entries if one.kind in {"changed", "reported"}]


async def adapt(home: Home, pauses: list[float], step: float = 2.0) -> None:
    """Change level and colour temperature a little, as adaptive lighting does in the evening."""
    level, kelvin = 80.0, 4000.0
    for pause in pauses:
        level, kelvin = level - step, kelvin - 50.0
        await home.report("lamp", "level", level)
        await home.report("lamp", "color_temperature", kelvin)
        await home.report("motion", "occupancy", False)
        await anyio.sleep(pause)


@pytest.mark.parametrize("pauses", [[90.0] * 8, [90.0, 180.0, 90.0, 360.0, 90.0, 270.0, 90.0, 180.0]])
async def test_adaptive_lighting_is_another_program_and_no_app_is_refused_for_it(
    open_home: OpenHome, pauses: list[float]
) -> None:
    async with open_home(presence_guard=True) as home:
        await put_lamp(home)
        lamp = await home.handle(Light, "lamp")
        await adapt(home, pauses[:3])
        assert isinstance(await lamp.turn_off(), Refused), "it may still be a person"
        await adapt(home, [*pauses[3:], *[90.0] * 16])
        why = await explain(home, "lamp")
        assert "another program did it past homebot" in finding_text(why, {}, home.graph.clock.now())
        assert (await causes(home))[-2:] == ["program", "program"]
        assert not isinstance(await lamp.turn_off(), Refused)


async def dim(home: Home, pause: float) -> None:
    """Turn a dial, in small steps, and back after a while."""
    for level in (70.0, 66.0, 62.0, 58.0, 54.0, 50.0):
        await home.report("lamp", "level", level)
        await anyio.sleep(1.0)
    await anyio.sleep(pause / 3.0)
    await home.report("lamp", "level", 80.0)


async def toggle(home: Home, pause: float) -> None:
    """Switch the lamp off and on."""
    await home.report("lamp", "on_off", False)
    await anyio.sleep(pause / 30.0)
    await home.report("lamp", "on_off", True)


@pytest.mark.parametrize("act", [dim, toggle])
async def test_a_person_at_the_lamp_stays_a_person(
    open_home: OpenHome, act: Callable[[Home, float], Awaitable[None]]
) -> None:
    async with open_home(presence_guard=True) as home:
        await put_lamp(home)
        for pause in (200.0, 341.0, 507.0, 613.0, 100.0, 77.0):
            await act(home, pause)
            await anyio.sleep(pause)
        assert "program" not in await causes(home)
        assert isinstance(await (await home.handle(Light, "lamp")).turn_off(), Refused)


async def test_the_schedule_of_a_thermostat_is_learnt_after_three_days_and_that_of_a_person_is_not(home: Home) -> None:
    """A person gets up by the clock, too."""
    await put_lamp(home)
    await home.new(Thermostat, "heating", "heating_setpoint", before={"heating_setpoint": 18.0})
    for _ in range(6):
        for hours, on_off, setpoint in ((8, False, 17.0), (16, True, 21.0)):
            await anyio.sleep(hours * HOUR)
            await home.report("lamp", "on_off", on_off)
            await home.report("heating", "heating_setpoint", setpoint)
    await anyio.sleep(1.0)
    entries = [one for one in (await home.read()).entries if one.kind == "changed"]
    assert {one.cause for one in entries if one.device == "lamp"} == {"person"}
    told = [one.cause for one in entries if one.device == "heating"]
    assert (told[:6], told[-4:]) == (["person"] * 6, ["program"] * 4)


async def test_another_program_outranks_a_lease_as_a_person_does(home: Home) -> None:
    await put_lamp(home)
    await adapt(home, [90.0] * 6)
    async with (await home.handle(Light, "lamp")).hold("0.66", by="robot"):
        await anyio.sleep(100.0)
        await home.report("lamp", "level", 63.0)
        await anyio.sleep(5.0)
        kinds = [(one.kind, one.cause) for one in (await home.read()).entries]
        assert ("changed", "program") in kinds
        assert ("outranked", "") in kinds
