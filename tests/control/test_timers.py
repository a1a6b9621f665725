"""Devices with a timer of their own: whose doing the end of a value is, and what a lease does; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, obey
from tests.control.test_explanations import explain

from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Contradicted
from homebot.devices.wording.journal_words import finding_text

pytestmark = pytest.mark.virtual_time


def turn_off_after(*seconds: float) -> Behaviour:
    """Obey, and turn off so many seconds after each "on", in turn; the last number is repeated."""
    left = list(seconds)

    async def behaviour(home: Home, command: Command) -> None:
        await obey(home, command)
        if command.value.plain() is True:
            home.later(left.pop(0) if len(left) > 1 else left[0], command.key, "on_off", False)

    return behaviour


async def staircase(home: Home, *seconds: float) -> Light:
    lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=turn_off_after(*seconds))
    await anyio.sleep(30)
    return lamp


async def turn_on(lamp: Light, times: int, pause: float) -> None:
    for _ in range(times):
        assert isinstance(await lamp.turn_on(), Confirmed)
        await anyio.sleep(pause)


async def told(home: Home) -> list[str]:
    """Return the causes of the changes that no entry of a command records, oldest first."""
    await anyio.sleep(1)
    return [one.cause for one in (await home.read()).entries if one.kind == "changed"]


@pytest.mark.parametrize("seconds", [25.0, 60.0, 600.0])
async def test_a_lamp_that_goes_off_as_long_after_each_command_does_so_by_itself(home: Home, seconds: float) -> None:
    lamp = await staircase(home, seconds, seconds + 0.3, seconds - 0.1, seconds + 0.2, seconds)
    await turn_on(lamp, 5, seconds + 30)
    first = "person" if seconds == 25.0 else "unknown"  # most timers are set to whole minutes
    assert await told(home) == [first, "unknown", "unknown", "device", "device"]
    why = await explain(home, "lamp")
    names = {one.key: one.value for one in why.names}
    assert finding_text(why, names, home.graph.clock.now()).endswith(": it did so by itself, as usual.")


async def test_a_person_who_is_faster_than_the_timer_is_named(home: Home) -> None:
    lamp = await staircase(home, 60.0)
    await turn_on(lamp, 4, 90)
    home.behaviours["lamp"] = turn_off_after(41.0, 60.0)
    await turn_on(lamp, 2, 90)
    assert (await told(home))[3:] == ["device", "person", "device"]


async def test_a_command_to_a_lamp_that_is_on_starts_its_timer_anew(home: Home) -> None:
    lamp = await staircase(home, 100.0)
    await turn_on(lamp, 3, 130)
    home.behaviours["lamp"] = turn_off_after(175.0, 100.0)  # the second command is 75 s after the first
    await lamp.turn_on()
    await anyio.sleep(75)
    await lamp.turn_on()
    await anyio.sleep(120)
    assert (await told(home))[3:] == ["device"]


async def test_people_at_other_times_are_no_timer_and_numbers_have_none(home: Home) -> None:
    lamp = await staircase(home, 30.0, 95.0, 61.0, 243.0, 17.0)
    await turn_on(lamp, 5, 300)
    assert await told(home) == ["person"] * 5


async def test_a_person_who_turns_on_and_off_as_regularly_is_no_timer(home: Home) -> None:
    """Only what a command began is timed."""
    await home.lamp("on_off", before={"on_off": False})
    for number in range(8):
        await anyio.sleep(40)
        await home.report("lamp", "on_off", number % 2 == 0)
    assert await told(home) == ["person"] * 8


async def test_a_timer_is_known_when_its_reports_are_forgotten(home: Home) -> None:
    lamp = await staircase(home, 60.0)
    await turn_on(lamp, 3, 90)
    await turn_on(lamp, 1, 16 * 60)  # longer than any report is remembered
    await turn_on(lamp, 1, 90)
    assert (await told(home))[3:] == ["device", "device"]


async def test_a_lamp_is_held_lit_behind_its_timer(home: Home) -> None:
    lamp = await staircase(home, 60.0)
    await turn_on(lamp, 3, 90)
    home.commands.clear()
    async with lamp.hold("on", by="robot", ttl=30) as held:
        await anyio.sleep(600)
        assert isinstance(held.outcome, Confirmed)
        assert held.is_held
        assert len(home.commands) == 10
    assert [one.kind for one in (await home.read()).entries if one.kind in {"outranked", "handed_back"}] == []


async def test_a_person_at_a_held_lamp_behind_a_timer_outranks_the_lease(home: Home) -> None:
    lamp = await staircase(home, 60.0)
    await turn_on(lamp, 3, 90)
    home.behaviours["lamp"] = turn_off_after(60.0, 33.0, 60.0)
    async with lamp.hold("on", by="robot", ttl=30) as held:
        await anyio.sleep(101)  # beyond the tenth renewal
        assert isinstance(held.outcome, Contradicted)


async def test_a_held_lamp_that_goes_back_soon_is_told_again_half_a_minute_later(home: Home) -> None:
    """As a gate that meets an obstacle."""
    lamp = await staircase(home, 4.0)
    await turn_on(lamp, 3, 60)
    home.commands.clear()
    async with lamp.hold("on", by="robot", ttl=30) as held:
        await anyio.sleep(100)
        assert len(home.commands) == 3
        assert held.is_held
