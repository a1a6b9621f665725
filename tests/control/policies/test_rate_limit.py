"""The rate limit: a strobe is stopped, and whoever dims or repeats a command never meets it; in virtual time."""

from collections.abc import Mapping
from itertools import count
from typing import Literal

import anyio
import pytest
from tests.call_counts import calls
from tests.control.conftest import Home, OpenHome, obey
from tests.control.policies.houses import START, make_command, make_device, make_facts, new_timeline

from homebot.control.command import IssuedCommand, order_of
from homebot.control.policies.rate_limit import RateLimitSettings, count_turns
from homebot.control.timeline.facts import Sent
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices.command_messages import CommandRequest, CommandResult, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Outcome, Refused
from homebot.devices.trigger import Trigger
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time

_NUMBERS = count()


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
    on: Mapping[str, PlainValue] = {"on_off": True}
    dark: Mapping[str, PlainValue] = {"level": 0.0}
    recent = sent(*((float(number), command(on if number % 2 else dark)) for number in range(10)))
    assert count_turns(recent, command(dark), 9.5, 10.0) == 9
    assert count_turns(recent, command(on), 9.5, 10.0) == 0


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
    on, off = command({"on_off": True}), command({"on_off": False})
    recent = sent((0.0, on), (1.0, off))
    recent.append(Sent(off.id, off.settings, 6.0))
    again = command({"on_off": True})
    assert (count_turns(recent, again, 7.0, 2.0), count_turns(recent, again, 7.0, 1.0)) == (1, 0)


def test_to_turn_on_again_what_reported_since_that_it_is_off_is_a_turn() -> None:
    """The command before was lost. A random day found it: the lamp was switched to and fro once more than it may be."""
    recent = sent((0.0, command({"on_off": True})))
    recent.report(5.0, START, "on_off", value=False)
    recent.append(Sent("again", {"level": 40.0}, 10.0))
    recent.report(11.0, START, "on_off", value=True)
    assert count_turns(recent, command({"on_off": False}), 12.0, 10.0) == 1


def test_to_turn_on_again_what_has_not_reported_since_is_none() -> None:
    """It may be slow."""
    recent = sent()
    recent.report(-1.0, START, "on_off", value=False)
    recent.sent.extend(Sent(f"again {number}", {"on_off": True}, float(number)) for number in range(10))
    assert count_turns(recent, command({"on_off": False}), 10.0, 10.0) == 0


def test_a_command_is_compared_with_none_that_were_sent_long_before() -> None:
    """The last two thousand took each command to a lamp of every day two milliseconds."""
    long_used = sent()
    long_used.sent.extend(
        Sent(f"c-{number}", {"on_off": number % 2 == 0}, -60.0 * number) for number in range(2000, 0, -1)
    )
    facts, one = make_facts(timeline=long_used), command({"on_off": True})
    assert calls(lambda: RateLimitSettings().judge(one, facts)) < 10


def command(settings: Mapping[str, PlainValue]) -> IssuedCommand:
    """Return a command to a lamp, with an id of its own."""
    lamp = make_device("lamp", "light", settable=("on_off", "level"))
    return make_command(lamp, settings, name=str(next(_NUMBERS)))


def sent(*commands: tuple[float, IssuedCommand]) -> PartTimeline:
    """Return the timeline of a lamp to which commands were sent, each at so many seconds."""
    device = make_device("lamp", "light")
    timeline = new_timeline(device, device.parts[0])
    for at, one in commands:
        timeline.command(order_of(one), at)
        timeline.append(Sent(one.id, one.settings, at))
    return timeline


async def test_the_limit_is_the_owners(open_home: OpenHome) -> None:
    async with open_home(rate_limit={"changes": 2, "seconds": 60}) as home:
        assert [one.succeeded for one in await blink(await home.lamp("on_off"), 5)] == [True, True, True, False, True]


@pytest.mark.parametrize(
    ("issuer", "kind", "capability", "sendings"),
    [
        ("client:local", "program", "on_off", 4),
        ("client:local", "", "on_off", 31),  # a person at the page
        ("client:robot", "program", "on_off", 31),
        ("client:local", "program", "level", 40),
    ],
)
async def test_a_program_without_a_token_turns_a_value_thrice_at_once(
    home: Home, issuer: str, kind: Literal["program", ""], capability: str, sendings: int
) -> None:
    """It dims as smoothly as others."""
    lamp, reasons = await home.lamp("on_off", "level"), ""
    for number in range(40):
        value: PlainValue = number % 2 == 0 if capability == "on_off" else 10.0 + number
        result = await home.control.perform(
            CommandRequest(
                device=lamp.device.id,
                settings=(Setting.of(capability, value),),
                issuer=issuer,
                scope=("act: all",),
                trigger=Trigger(kind=kind),
            )
        )
        reasons += CommandResult.of(result).reason
    assert len(home.commands) == sendings
    advice = "with a token (`homebot token new`) a program may more often"
    assert (advice in reasons) is (sendings == 4)


async def test_a_program_without_a_token_turns_a_value_once_a_second(home: Home) -> None:
    lamp = await home.lamp("on_off")
    for number in range(60):
        await home.control.perform(
            CommandRequest(
                device=lamp.device.id,
                settings=(Setting.of("on_off", number % 2 == 0),),
                issuer="client:local",
                scope=("act: all",),
                trigger=Trigger(kind="program"),
            )
        )
        await anyio.sleep(0.5)
    assert 30 <= len(home.commands) <= 33


async def test_it_can_be_turned_off(open_home: OpenHome) -> None:
    async with open_home(rate_limit=False) as home:
        assert all(one.succeeded for one in await blink(await home.lamp("on_off"), 100))
