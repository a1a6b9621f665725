"""When a command is sent again, and when it is not, as it may have been obeyed; in virtual time."""

import itertools

import anyio
import pytest
from tests.control.conftest import Home, ignore, obey, obey_after

from homebot.control.durations import ACKNOWLEDGED_TOO
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import Handle, Light
from homebot.devices.outcomes import Confirmed, NoAnswer, Superseded
from homebot.support.unanswered import awaiting_answer

pytestmark = pytest.mark.virtual_time


def lose_connection(home: Home) -> None:
    """Let the gateway lose its connection, and have it again at once."""
    home.gateway.set_unavailable("the broker was killed")
    home.gateway.set_available()


async def lose_connection_and_answer(home: Home, command: Command) -> None:
    """Lose the connection before the lamp can report anything."""
    lose_connection(home)


async def test_a_command_is_not_repeated_after_the_connection_was_lost_as_it_may_have_been_obeyed(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=lose_connection_and_answer)
    outcome = await lamp.turn_on()
    assert outcome == NoAnswer(10.0, command_id=outcome.command_id)
    assert len(home.commands) == 1


async def test_it_is_repeated_once_the_lamp_reports_that_it_is_still_off(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    sent_at: list[float] = []

    async def come_back_after_six_seconds(home: Home, command: Command) -> None:
        sent_at.append(anyio.current_time())
        if len(sent_at) == 1:
            lose_connection(home)
            home.later(6.0, command.key, "on_off", value=False)
        else:
            home.later(0.1, command.key, "on_off", value=True)

    home.behaviours["lamp"] = come_back_after_six_seconds
    assert isinstance(await (await home.handle(Light)).turn_on(), Confirmed)
    assert [round(at - sent_at[0], 1) for at in sent_at] == [0.0, 6.0]


async def test_it_is_confirmed_without_a_repetition_where_the_lamp_reports_that_it_is_on(home: Home) -> None:

    async def obey_late(home: Home, command: Command) -> None:
        lose_connection(home)
        home.later(8.0, command.key, "on_off", value=True)

    assert isinstance(await (await home.lamp("on_off", behaviour=obey_late)).turn_on(), Confirmed)
    assert len(home.commands) == 1


async def test_a_connection_that_was_lost_before_the_command_does_not_matter(home: Home) -> None:
    lamp = await home.lamp("on_off")
    await lamp.turn_off()
    lose_connection(home)
    await anyio.sleep(1.0)
    home.behaviours["lamp"] = ignore
    home.commands.clear()
    assert isinstance(await lamp.turn_on(), NoAnswer)
    assert len(home.commands) == 3


async def test_the_network_forgets_a_command_before_it_is_sent_again(home: Home) -> None:
    """So that a device that was away never gets two copies of it: one that it answers in time stays the only one."""
    lamp = await home.lamp("on_off", behaviour=obey_after(0.4))
    for number in range(4):
        await (lamp.turn_off() if number % 2 else lamp.turn_on())
    home.behaviours["lamp"] = ignore
    home.commands.clear()
    sent_at: list[float] = []

    async def note(_home: Home, _command: Command) -> None:
        sent_at.append(anyio.current_time())

    home.behaviours["lamp"] = note
    await lamp.turn_on()
    assert [one.repeated for one in home.commands] == [False, True, True]  # where nothing expires only that helps
    kept_for = [one.kept_for for one in home.commands]
    assert kept_for == pytest.approx([1.5, 1.5, 0.0], abs=0.01)
    for seconds, (before, after) in zip(kept_for, itertools.pairwise(sent_at), strict=False):
        assert after - before >= seconds + 0.4 - 0.01
    assert home.commands[-1].expires_after == pytest.approx(10.0 - 2 * 1.9, abs=0.01)  # until the outcome is told


async def freeze(_home: Home, _command: Command) -> None:
    """Send the command into a network that does not acknowledge it."""
    with awaiting_answer():
        await anyio.sleep_forever()


async def test_what_the_network_did_not_acknowledge_was_sent_once_and_may_arrive_later(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=freeze)
    outcome = await lamp.turn_on()
    assert outcome == NoAnswer(10.0, is_unacknowledged=True, command_id=outcome.command_id)
    assert outcome.was_sent
    assert outcome.text == "no answer within 10 s; its network has not acknowledged it, and may still deliver it"
    assert len(home.commands) == 1


async def test_neither_an_echo_nor_what_was_so_before_takes_its_place(home: Home) -> None:
    lamp = await home.lamp("on_off", echoed=("on_off",))
    await lamp.turn_on()
    await anyio.sleep(100)
    home.behaviours["lamp"] = freeze
    outcome = await lamp.turn_on()
    assert isinstance(outcome, NoAnswer)
    assert outcome.is_unacknowledged


async def test_a_press_that_the_network_did_not_acknowledge_is_not_confirmed(home: Home) -> None:
    outcome = await (
        await home.new(Handle, "lamp", "push", service_type="generic_switch", is_silent=True, behaviour=freeze)
    ).command("push", value=True)
    assert isinstance(outcome, NoAnswer)
    assert outcome.is_unacknowledged
    assert len(home.commands) == 1


async def test_a_report_confirms_what_the_network_did_not_acknowledge(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=freeze)
    began = anyio.current_time()
    home.later(4.0, "lamp", "on_off", value=True)
    assert isinstance(await lamp.turn_on(), Confirmed)
    assert anyio.current_time() - began == pytest.approx(4.0 + ACKNOWLEDGED_TOO)


async def test_a_newer_command_ends_the_wait_for_an_acknowledgement(home: Home) -> None:
    """Where the older one still waits for a connection it is not sent after the newer one."""
    lamp = await home.lamp("on_off", behaviour=freeze)
    outcomes = home.begin(lamp.turn_on)
    await anyio.sleep(1.0)
    home.behaviours["lamp"] = obey
    newer = await lamp.turn_off()
    await anyio.sleep(ACKNOWLEDGED_TOO + 0.1)
    assert outcomes == [Superseded(newer.command_id, command_id=outcomes[0].command_id)]
