"""The rate limit: a strobe is stopped, and whoever dims or repeats a command never meets it; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home, OpenHome, obey
from tests.control.policies.houses import START, make_command, make_device

from homebot.control.policies.rate_limit import TurnCounter
from homebot.devices import Device
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Outcome, Refused

pytestmark = pytest.mark.virtual_time


async def blink(lamp: Light, times: int) -> list[Outcome]:
    """Switch a lamp on and off so often, as fast as it obeys."""
    return [await (lamp.turn_off() if number % 2 else lamp.turn_on()) for number in range(times)]


async def test_a_strobe_is_stopped(home: Home) -> None:
    outcomes = await blink(await home.lamp("on_off"), 40)
    refused = [one for one in outcomes if isinstance(one, Refused)]
    assert len(home.commands) == 31  # the first is no change
    assert refused[0].policy == "rate_limit"
    assert refused[0].reason == "lamp was switched back and forth 30 times within 10 s"


async def test_it_obeys_again_after_a_while(home: Home) -> None:
    lamp = await home.lamp("on_off")
    await blink(lamp, 40)
    await anyio.sleep(10.1)
    assert all(one.succeeded for one in await blink(lamp, 20))


async def test_dimming_is_no_strobe(home: Home) -> None:
    lamp = await home.lamp("on_off", "level")
    assert all([(await lamp.set_level(level)).succeeded for level in range(100, 0, -1)])


def test_a_strobe_by_brightness_and_switch_in_turn_is_counted() -> None:
    """Each of the two alone never turns round."""
    lamp, recent = make_device("lamp", "light", settable=("on_off", "level")), TurnCounter()
    on, dark = make_command(lamp, {"on_off": True}), make_command(lamp, {"level": 0.0})
    for number in range(10):
        recent.record(on if number % 2 else dark, float(number))
    assert recent.count(dark, 9.0, 10.0) == 9
    assert recent.count(on, 9.0, 10.0) == 0


async def test_a_command_that_is_still_being_sent_counts(open_home: OpenHome) -> None:
    """A gateway may first have to connect."""
    async with open_home(rate_limit={"changes": 1, "seconds": 10}) as home:
        lamp = await home.lamp("on_off")
        assert (await lamp.turn_on()).succeeded
        home.behaviours["lamp"] = obey_slowly
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(lamp.turn_off)
            await anyio.sleep(1)
            assert isinstance(await lamp.turn_on(), Refused)


async def obey_slowly(home: Home, command: Command) -> None:
    """Be reached after three seconds."""
    await anyio.sleep(3)
    await obey(home, command)


def test_a_turn_counts_from_the_last_try() -> None:
    """The device may have missed those before."""
    lamp, recent = make_device("lamp", "light", settable=("on_off",)), TurnCounter()
    on, off = make_command(lamp, {"on_off": True}), make_command(lamp, {"on_off": False})
    recent.record(on, 0.0)
    recent.record(off, 1.0)
    recent.record(off, 6.0)
    assert (recent.count(on, 7.0, 2.0), recent.count(on, 7.0, 1.0)) == (1, 0)


def test_to_turn_on_again_what_reported_since_that_it_is_off_is_a_turn() -> None:
    """The command before was lost. A random day found it: the lamp was switched to and fro once more than it may be."""
    recent = TurnCounter()
    before = lamp_that_was(on=False, told=-100.0)
    recent.record(make_command(before, {"on_off": True}, at=START), 0.0)
    again = make_command(lamp_that_was(on=False, told=5.0), {"level": 40.0}, name="2", at=START + 10.0)
    recent.record(again, 10.0)
    off = make_command(lamp_that_was(on=True, told=11.0), {"on_off": False}, name="3", at=START + 12.0)
    assert recent.count(off, 12.0, 10.0) == 1


def test_to_turn_on_again_what_has_not_reported_since_is_none() -> None:
    """It may be slow."""
    recent = TurnCounter()
    slow = lamp_that_was(on=False, told=-1.0)
    for number in range(10):
        recent.record(make_command(slow, {"on_off": True}, name=str(number), at=START + number), float(number))
    assert recent.count(make_command(slow, {"on_off": False}, at=START + 10.0), 10.0, 10.0) == 0


def lamp_that_was(*, on: bool, told: float) -> Device:
    """A lamp that reported so many seconds after the start whether it is on."""
    return make_device("lamp", "light", settable=("level",), since=START + told, values={"on_off": on})


async def test_the_limit_is_the_owners(open_home: OpenHome) -> None:
    async with open_home(rate_limit={"changes": 2, "seconds": 60}) as home:
        assert [one.succeeded for one in await blink(await home.lamp("on_off"), 5)] == [True, True, True, False, True]


async def test_it_can_be_turned_off(open_home: OpenHome) -> None:
    async with open_home(rate_limit=False) as home:
        assert all(one.succeeded for one in await blink(await home.lamp("on_off"), 100))
