"""Outcomes of dimmers with a ramp of their own, of which the command says nothing; in virtual time."""

from collections.abc import Callable
from typing import TypeAlias

import anyio
import pytest
from tests.control.conftest import Behaviour, Home, OpenHome, end_of_ramp, ignore

from homebot.devices.command_messages import CommandRequest, PerformCommand, Setting
from homebot.devices.gateway_messages import Command
from homebot.devices.names import PERFORM_COMMAND
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, NoAnswer, Outcome
from homebot.devices.value import PlainValue

pytestmark = pytest.mark.virtual_time

Told: TypeAlias = Callable[[float], dict[str, PlainValue]]


def on_and_level(level: float) -> dict[str, PlainValue]:
    """What Z-Wave JS UI reports of a dimmer."""
    return {"on_off": level > 0, "level": level}


def level_alone(level: float) -> dict[str, PlainValue]:
    return {"level": level}


def ramp(begin: float, seconds: float, told: Told, *, stuck_at: float | None = None) -> Behaviour:
    """Fade within so many seconds, with a report for each; another command on the way begins the ramp anew."""
    now_at, ramps = [begin], [0]

    async def behaviour(home: Home, command: Command) -> None:
        value = command.value.plain()
        goal = value if isinstance(value, float) else 100.0 if value else 0.0
        ramps[0] += 1
        home.tasks.start_soon(fade, home, command.key, goal, ramps[0])

    async def fade(home: Home, key: str, goal: float, number: int) -> None:
        start, steps = now_at[0], int(seconds)
        for step in range(1, steps + 1):
            await anyio.sleep(1.0)
            if number != ramps[0]:
                return
            level = start + (goal - start) * step / steps
            now_at[0] = level if stuck_at is None else max(level, stuck_at)
            await home.gateway.devices.report(key, told(now_at[0]))

    return behaviour


async def commanded(
    open_home: OpenHome, begin: float, setting: tuple[str, PlainValue], behaviour: Behaviour
) -> tuple[Outcome, int]:
    async with open_home() as home:
        lamp = await home.lamp("on_off", "level")
        await home.gateway.devices.report("lamp", on_and_level(begin))
        await anyio.sleep(1)
        home.behaviours["lamp"] = behaviour
        return await lamp.command(*setting), len(home.commands)


@pytest.mark.parametrize("seconds", [4.0, 8.0, 20.0])
@pytest.mark.parametrize("told", [on_and_level, level_alone])
async def test_a_dimmer_on_its_way_to_a_level_is_not_told_again(
    open_home: OpenHome, seconds: float, told: Told
) -> None:
    outcome, sendings = await commanded(open_home, 100.0, ("level", 20.0), ramp(100.0, seconds, told))
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (seconds, 1)


@pytest.mark.parametrize("seconds", [4.0, 8.0, 20.0])
async def test_a_dimmer_that_is_on_until_it_is_dark_obeyed(open_home: OpenHome, seconds: float) -> None:
    outcome, sendings = await commanded(open_home, 99.0, ("on_off", False), ramp(99.0, seconds, on_and_level))
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (seconds, 1)


async def test_a_dimmer_that_is_off_fades_up_from_nothing(open_home: OpenHome) -> None:
    outcome, sendings = await commanded(open_home, 0.0, ("level", 80.0), ramp(0.0, 8.0, on_and_level))
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), sendings) == (8, 1)


@pytest.mark.parametrize("stuck_at", [60.0, 40.0])
async def test_a_dimmer_that_gets_stuck_on_its_way_is_told_again_and_contradicted(
    open_home: OpenHome, stuck_at: float
) -> None:
    """It is told again after a silence, which ends later than commands to other devices."""
    behaviour = ramp(100.0, 8.0, on_and_level, stuck_at=stuck_at)
    outcome, sendings = await commanded(open_home, 100.0, ("level", 20.0), behaviour)
    assert isinstance(outcome, Contradicted)
    assert (outcome.saw, sendings > 1) == (f"level is {stuck_at:g}", True)


async def test_a_dimmer_that_reports_the_end_of_its_ramp_alone_is_told_once_after_it_gave_no_answer(home: Home) -> None:
    """Its ramp takes longer than it is waited for before a repetition, which begins it anew."""
    ramps, fade = end_of_ramp(6)
    lamp = await home.lamp("on_off", "level", behaviour=fade)
    found: list[tuple[type[Outcome], int]] = []
    for on in (True, False, True, False):
        before = len(ramps)
        outcome = await (lamp.turn_on() if on else lamp.turn_off())
        found.append((type(outcome), len(ramps) - before))
        await anyio.sleep(60)
    assert found == [(NoAnswer, 3), (Confirmed, 1), (Confirmed, 1), (Confirmed, 1)]


async def test_a_deaf_dimmer_is_told_three_times_again_after_it_was_told_once(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", behaviour=ignore)
    sendings: list[int] = []
    for _ in range(3):
        before = len(home.commands)
        assert isinstance(await lamp.turn_on(), NoAnswer)
        sendings.append(len(home.commands) - before)
    assert sendings == [3, 1, 3]


@pytest.mark.parametrize(("levels", "reverted"), [((70.0, 40.0, 10.0), 0), ((70.0, 70.0, 70.0), 1)])
async def test_a_lamp_of_unknown_level_fades_off_beyond_its_transition_if_its_level_sinks(
    home: Home, levels: tuple[float, ...], reverted: int
) -> None:
    """The levels of its steps tell, as homebot started when it was on already."""
    lamp = await home.lamp("on_off", "level", before={"on_off": True})
    assert isinstance(await lamp.command("on_off", False, transition=2.0), Confirmed)
    for level in levels:
        await anyio.sleep(0.6)
        await home.gateway.devices.report("lamp", on_and_level(level))
    await anyio.sleep(0.5)
    await home.report("lamp", "on_off", False)
    await anyio.sleep(20)
    assert len(home.events) == reverted


@pytest.mark.parametrize(
    ("told", "reverted_after"),
    [
        ([{"on_off": True, "level": 100.0}], 1),  # one message with the level of before
        ([{"level": 100.0, "on_off": True}], 1),
        ([{"on_off": True}, {"level": 100.0}], 1),
        ([{"on_off": True}], 2),  # and no level
        ([{"on_off": True}, {"level": 70.0}], 11),  # it stays there
        ([{"on_off": True}, {"level": 70.0}, {"level": 30.0}, {"on_off": False}], None),
        ([{"level": 70.0, "on_off": True}, {"level": 30.0, "on_off": True}, {"on_off": False}], None),
        ([{"on_off": True}, {"level": 70.0}, {"on_off": True}, {"level": 90.0}], 1),
    ],
)
async def test_a_lamp_that_is_on_again_went_back_unless_its_level_sinks(
    home: Home, told: list[dict[str, PlainValue]], reverted_after: int | None
) -> None:
    """A bridge with a transition of its own reports that it is off before the lamp has faded off."""
    lamp = await home.lamp("on_off", "level")
    await home.gateway.devices.report("lamp", on_and_level(100.0))
    await anyio.sleep(1)

    async def tell(home: Home, _: Command) -> None:
        await home.report("lamp", "on_off", False)
        home.tasks.start_soon(fade)

    async def fade() -> None:
        await anyio.sleep(0.9)
        for one in told:
            await anyio.sleep(0.1)
            await home.gateway.devices.report("lamp", one)

    home.behaviours["lamp"] = tell
    assert isinstance(await lamp.turn_off(), Confirmed)
    began, reverted = anyio.current_time(), None
    while reverted is None and anyio.current_time() < began + 30:
        await anyio.sleep(0.1)
        reverted = round(anyio.current_time() - began) if home.events else None
    assert reverted == reverted_after


async def test_no_echo_is_learnt_from_a_lamp_that_fades_off(home: Home) -> None:
    lamp = await home.lamp("on_off", "level")

    async def tell(home: Home, command: Command) -> None:
        on = command.value.plain()
        await home.gateway.devices.report("lamp", {"on_off": True, "level": 100.0} if on else {"on_off": False})
        if not on:
            home.tasks.start_soon(fade)

    async def fade() -> None:
        for level in (80.0, 60.0, 40.0, 20.0):
            await anyio.sleep(1)
            await home.gateway.devices.report("lamp", {"on_off": level > 20.0, "level": level})

    home.behaviours["lamp"] = tell
    for number in range(8):
        outcome = await (lamp.turn_off() if number % 2 else lamp.turn_on())
        assert isinstance(outcome, Confirmed)
        assert (outcome.latency < 0.1, outcome.evidence) == (True, Evidence.REPORTED)
        await anyio.sleep(30)
    assert (home.events, len(home.commands)) == ([], 8)


async def test_a_lamp_is_not_turned_on_again_over_a_hand_that_looks_like_its_timer(home: Home) -> None:
    """Its "off" ends what a command brought, so nothing was lost on the way."""

    async def fade(home: Home, command: Command) -> None:
        if command.capability == "on_off":
            await home.report("lamp", "on_off", True)
            home.later(1.0, "lamp", "level", 20.0)

    await home.lamp("on_off", "level", before={"on_off": False, "level": 10.0}, behaviour=fade)
    perform = home.app.create_client(PerformCommand, PERFORM_COMMAND)
    wanted = (Setting.of("on_off", True), Setting.of("level", 80.0))
    for sendings in range(1, 7):
        await home.report("lamp", "level", 10.0)
        home.later(4.0, "lamp", "on_off", False)
        request = CommandRequest(device="lamp", settings=wanted, issuer="/app")
        assert isinstance(await perform.call(request, timeout=900), Contradicted)
        assert len(home.commands) == 2 * sendings
        await anyio.sleep(120)
