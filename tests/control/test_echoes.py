"""Commands to bridges that report what was commanded before the device obeyed; in virtual time."""

import anyio
import pytest
from tests.control.conftest import Home, report

from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Light
from homebot.devices.outcomes import Confirmed, Contradicted, Evidence, Outcome

pytestmark = pytest.mark.virtual_time

ECHO = 0.005


async def lamp_of(home: Home, *, declared: bool) -> Light:
    return await home.lamp("on_off", echoed=("on_off",) if declared else ())


async def seconds_and_outcome(home: Home, lamp: Light, *values: tuple[float, bool]) -> tuple[float, Outcome]:
    """Turn the lamp on, which then reports the values at these seconds."""
    home.behaviours["lamp"] = report(*values)
    began = anyio.current_time()
    outcome = await lamp.turn_on()
    return round(anyio.current_time() - began, 3), outcome


async def test_a_declared_echo_is_no_report(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    seconds, outcome = await seconds_and_outcome(home, lamp, (ECHO, True))
    assert isinstance(outcome, Confirmed)
    assert (outcome.evidence, round(outcome.latency, 3), seconds) == (Evidence.ACKNOWLEDGED, ECHO, 2.005)
    assert outcome.text == "accepted by the network after 0.005 s (acknowledged)"


async def test_where_nothing_ever_follows_the_echo_nobody_waits(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    waited = [(await seconds_and_outcome(home, lamp, (ECHO, True)))[0] for _ in range(5)]
    assert waited == [2.005, 2.005, 2.005, 0, 0]


async def test_an_echo_without_a_sound_is_acknowledged_all_the_same(home: Home) -> None:
    """As where the state topic is the command topic: what we publish there does not come back to us."""
    lamp = await lamp_of(home, declared=True)
    seconds, outcome = await seconds_and_outcome(home, lamp)
    assert isinstance(outcome, Confirmed)
    assert (outcome.evidence, seconds) == (Evidence.ACKNOWLEDGED, 2)


async def test_a_report_after_the_echo_is_one(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    seconds, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (0.4, True))
    assert isinstance(outcome, Confirmed)
    assert (outcome.evidence, seconds) == (Evidence.REPORTED, 0.4)


async def test_a_slow_device_behind_a_bridge_that_answers_later_is_waited_for(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    await seconds_and_outcome(home, lamp, (ECHO, True), (0.4, True))
    _, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (0.5, False), (7.0, True))
    assert isinstance(outcome, Confirmed)
    assert outcome.evidence is Evidence.REPORTED


async def test_an_echo_that_is_taken_back_is_contradicted_although_repeating_it_is_echoed(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    _, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (1.0, False))
    assert isinstance(outcome, Contradicted)
    assert len(home.commands) == 3


async def test_an_echo_that_is_taken_back_later_is_told_as_an_event(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    await seconds_and_outcome(home, lamp, (ECHO, True), (5.0, False))
    await anyio.sleep(10)
    assert [one.result.outcome for one in home.events] == ["reverted"]
    seconds, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (5.0, False))
    assert isinstance(outcome, Contradicted)
    assert seconds == 10


async def test_an_echo_is_no_reason_to_send_nothing(home: Home) -> None:
    lamp = await lamp_of(home, declared=True)
    await seconds_and_outcome(home, lamp, (ECHO, True))
    await seconds_and_outcome(home, lamp, (ECHO, True))
    assert len(home.commands) == 2


async def learn_echo(home: Home, lamp: Light) -> None:
    """Turn the lamp on three times, and let the bridge take its report back each time, after the same time."""
    for _ in range(3):
        await seconds_and_outcome(home, lamp, (ECHO, True), (1.5, False))
        await anyio.sleep(20)


async def test_fast_reports_that_are_taken_back_alike_are_learnt_to_be_echoes(home: Home) -> None:
    lamp = await lamp_of(home, declared=False)
    await learn_echo(home, lamp)
    assert [one.result.outcome for one in home.events] == ["reverted"] * 3
    _, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (0.4, True))
    assert isinstance(outcome, Confirmed)
    assert (outcome.evidence, round(outcome.latency, 3)) == (Evidence.REPORTED, 0.4)
    await home.report("lamp", "on_off", False)
    await learn_echo(home, lamp)
    _, outcome = await seconds_and_outcome(home, lamp, (ECHO, True))
    assert isinstance(outcome, Confirmed)
    assert outcome.evidence is Evidence.ACKNOWLEDGED


async def test_a_learnt_echo_that_is_taken_back_is_contradicted_and_never_repeated(home: Home) -> None:
    """It may be a person after all, who is not overridden."""
    lamp = await lamp_of(home, declared=False)
    await learn_echo(home, lamp)
    home.commands.clear()
    _, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (1.5, False))
    assert isinstance(outcome, Contradicted)
    assert len(home.commands) == 1


async def test_reports_that_are_taken_back_now_and_then_are_persons_rather_than_echoes(home: Home) -> None:
    lamp = await lamp_of(home, declared=False)
    for after in (4.0, 0.5, 2.5, 1.2, 2.9):
        _, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (after, False))
        assert isinstance(outcome, Confirmed)
        assert outcome.evidence is Evidence.REPORTED
        await anyio.sleep(20)


async def test_one_value_that_is_taken_back_says_nothing_of_the_others(home: Home) -> None:
    async def behaviour(home: Home, command: Command) -> None:
        home.later(ECHO, "lamp", command.capability, command.value.plain())
        if command.capability == "color_temperature":
            home.later(1.5, "lamp", command.capability, 6500.0)

    lamp = await home.lamp("on_off", "level", "color_temperature", echoed=("color_temperature",), behaviour=behaviour)
    for level in (10, 20, 30):
        outcome = await lamp.turn_on(level=level, kelvin=2700)
        assert isinstance(outcome, Contradicted)
        assert outcome.saw == "color_temperature is 6500"
        await anyio.sleep(20)
    began = anyio.current_time()
    assert isinstance(await lamp.set_level(40), Confirmed)
    assert anyio.current_time() - began == pytest.approx(ECHO)


async def test_an_echo_that_holds_once_is_believed_again(home: Home) -> None:
    lamp = await lamp_of(home, declared=False)
    await learn_echo(home, lamp)
    await seconds_and_outcome(home, lamp, (ECHO, True), (0.4, True))
    await anyio.sleep(20)
    await home.report("lamp", "on_off", False)
    await anyio.sleep(1)
    seconds, outcome = await seconds_and_outcome(home, lamp, (ECHO, True))
    assert isinstance(outcome, Confirmed)
    assert (outcome.evidence, seconds) == (Evidence.REPORTED, ECHO)


async def test_a_fast_honest_lamp_that_somebody_switched_by_hand_once_is_not_waited_for(home: Home) -> None:
    lamp = await lamp_of(home, declared=False)
    await seconds_and_outcome(home, lamp, (ECHO, True), (3.0, False))
    await anyio.sleep(20)
    for _ in range(5):
        seconds, outcome = await seconds_and_outcome(home, lamp, (ECHO, True))
        assert isinstance(outcome, Confirmed)
        assert (outcome.evidence, seconds) == (Evidence.REPORTED, ECHO)
        await anyio.sleep(20)
        await home.report("lamp", "on_off", False)
        await anyio.sleep(1)


async def test_a_lamp_that_goes_back_by_a_timer_of_its_own_is_no_echo(home: Home) -> None:
    """It did obey, each time: that is told at once, and later that it went back."""
    lamp = await lamp_of(home, declared=False)
    for number in range(1, 6):
        seconds, outcome = await seconds_and_outcome(home, lamp, (ECHO, True), (5.0 + 0.05 * number, False))
        assert isinstance(outcome, Confirmed)
        assert (outcome.evidence, seconds) == (Evidence.REPORTED, ECHO)
        await anyio.sleep(20)
        assert [one.result.outcome for one in home.events] == ["reverted"] * number


async def test_an_echo_when_it_is_sent_again_takes_no_slow_answer_back(home: Home) -> None:
    async def behaviour(home: Home, command: Command) -> None:
        is_again = [one.capability for one in home.commands].count(command.capability) > 1
        if command.capability == "on_off":
            home.later(ECHO if is_again else 0.4, "lamp", "on_off", True)
        elif is_again:
            home.later(0.5, "lamp", "level", command.value.plain())

    lamp = await home.lamp("on_off", "level", "color_temperature")
    await learn_echo(home, lamp)
    home.commands.clear()
    home.behaviours["lamp"] = behaviour
    outcome = await lamp.commands({"on_off": True, "level": 40.0})
    assert isinstance(outcome, Confirmed)
    assert outcome.evidence is Evidence.REPORTED
    assert [one.capability for one in home.commands] == ["level", "on_off"] * 2
