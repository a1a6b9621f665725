"""What a command returns, for everything that a device may do with it; in virtual time."""

from functools import partial
from typing import TypeAlias

import anyio
import pytest
from structlog.testing import capture_logs
from tests.control.conftest import Behaviour, Home, OpenHome, ignore, obey, obey_after, report

from homebot.devices.command_messages import (
    CommandRequest,
    CommandResult,
    PerformCommand,
    SendText,
    SendTextRequest,
    Setting,
)
from homebot.devices.gateway_messages import Command
from homebot.devices.handles import DoorLock, Handle, Light, Switch, Thermostat, WindowCovering
from homebot.devices.names import PERFORM_COMMAND, SEND_TEXT
from homebot.devices.outcomes import (
    AlreadySo,
    Confirmed,
    Contradicted,
    Evidence,
    Gone,
    NoAnswer,
    Outcome,
    Refused,
    Superseded,
)
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

pytestmark = pytest.mark.virtual_time


async def test_a_lamp_that_reports_is_confirmed_with_its_latency(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=obey_after(0.12))
    outcome = await lamp.turn_on()
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency, 2), outcome.evidence, outcome.succeeded) == (0.12, Evidence.REPORTED, True)
    assert (outcome.command_id != "", outcome.reported) == (True, {"on_off": True})


async def test_the_service_answers_with_the_outcome_itself(home: Home) -> None:
    """In the process; the border of the process makes a message of it."""
    lamp = await home.lamp("on_off")
    wanted = (Setting.of("on_off", True),)
    request = CommandRequest(device=lamp.device.id, settings=wanted, issuer="/app")
    outcome = await home.app.create_client(PerformCommand, PERFORM_COMMAND).call(request)
    assert isinstance(outcome, Confirmed)
    assert CommandResult.of(outcome).reported == wanted


async def test_a_slow_but_honest_lamp_is_no_false_alarm(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=obey_after(7.5))
    assert isinstance(await lamp.turn_on(), Confirmed)
    assert len(home.commands) == 3  # sent again meanwhile, which does no harm


async def test_a_deaf_lamp_gives_no_answer_and_is_told_three_times(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=ignore)
    outcome = await lamp.turn_on()
    assert outcome == NoAnswer(10.0, command_id=outcome.command_id)
    assert len(home.commands) == 3


async def test_a_lamp_that_is_known_to_be_fast_is_told_again_sooner_and_waited_for_as_long(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=obey_after(0.5))
    for _ in range(3):
        await lamp.turn_on()
        await lamp.turn_off()
    told_at: list[float] = []

    async def note(_home: Home, _command: Command) -> None:
        told_at.append(anyio.current_time())

    home.behaviours["lamp"] = note
    outcome = await lamp.turn_on()
    assert outcome == NoAnswer(10.0, command_id=outcome.command_id)
    assert [round(at - told_at[0], 2) for at in told_at] == [0.0, 2.0, 4.0]


@pytest.mark.parametrize("beat", [0.7, 3.0, 100.0])
async def test_a_fast_lamp_that_becomes_slow_is_no_false_alarm(home: Home, beat: float) -> None:
    """Not even if it says again and again how it is, as many do."""
    lamp = await home.lamp("on_off")
    is_on = False

    async def be_slow(home: Home, command: Command) -> None:
        async def act() -> None:
            nonlocal is_on
            await anyio.sleep(8.0)
            is_on = command.value.plain() is True
            await home.report("lamp", "on_off", is_on)

        home.tasks.start_soon(act)

    async def repeat() -> None:
        while True:
            await anyio.sleep(beat)
            await home.report("lamp", "on_off", is_on)

    for number in range(20):
        await (lamp.turn_off() if number % 2 else lamp.turn_on())
    home.behaviours["lamp"] = be_slow
    home.tasks.start_soon(repeat)
    for number in range(10):
        outcome = await (lamp.turn_off() if number % 2 else lamp.turn_on())
        assert isinstance(outcome, Confirmed)
        assert round(outcome.latency) == 8
        await anyio.sleep(40)


async def test_a_stuck_lamp_that_answers_with_the_old_state_is_contradicted(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=report((2.0, False)))
    outcome = await lamp.turn_on()
    assert isinstance(outcome, Contradicted)
    assert outcome.saw == "on_off is off"


async def test_a_lamp_that_is_off_and_keeps_its_brightness_obeyed_a_level_of_0(home: Home) -> None:
    """As Zigbee2MQTT and Home Assistant's JSON lamps report it: ``{"state": "OFF", "brightness": 254}``."""

    async def be_off(home: Home, command: Command) -> None:
        await home.report("lamp", "on_off", False)
        await home.report("lamp", "level", 100.0)

    lamp = await home.lamp("on_off", "level", before={"on_off": True}, behaviour=be_off)
    assert isinstance(await lamp.command("level", 0.0), Confirmed)
    assert isinstance(await lamp.command("level", 0.0), AlreadySo)
    assert [(one.capability, one.value.plain()) for one in home.commands] == [("on_off", False)]


@pytest.mark.parametrize(
    ("capability", "value"), [("level", 40.0), ("color_temperature", 2700.0), ("color", (120.0, 80.0))]
)
@pytest.mark.parametrize("is_stuck", [False, True])
async def test_a_lamp_that_is_off_at_the_wanted_level_or_colour_is_not_on_already(
    home: Home, capability: str, value: PlainValue, *, is_stuck: bool
) -> None:
    """Most lamps report while they are off what they will be when they are on."""

    async def light_up(home: Home, command: Command) -> None:
        await home.report("lamp", command.capability, command.value.plain())
        await home.report("lamp", "on_off", not is_stuck)

    lamp = await home.lamp("on_off", capability, before={"on_off": False, capability: value}, behaviour=light_up)
    assert isinstance(await lamp.command(capability, value), Contradicted if is_stuck else Confirmed)
    assert [(one.capability, one.value.plain()) for one in home.commands][:1] == [(capability, value)]
    if not is_stuck:
        assert isinstance(await lamp.command(capability, value), AlreadySo)
        home.behaviours["lamp"] = obey
        await lamp.turn_off()
        await anyio.sleep(20)
        assert home.events == []  # it did not go back: it was turned off


@pytest.mark.parametrize("other", [None, 10.0])
async def test_a_lamp_that_reports_only_what_changed_is_on_as_it_was(home: Home, other: float | None) -> None:
    """Hue bridges and Matter nodes do so; another value that follows counts."""
    home.put("lamp", "light", "on_off", "level", "color_temperature")
    await home.gateway.devices.report("lamp", {"on_off": False, "level": 80.0, "color_temperature": 2703.0})

    async def light_up(home: Home, command: Command) -> None:
        await home.report("lamp", "on_off", True)
        if other is not None:
            home.later(0.5, "lamp", "level", other)

    home.behaviours["lamp"] = light_up
    await anyio.sleep(120)
    outcome = await (await home.handle(Light)).turn_on(level=80, kelvin=2700)
    assert isinstance(outcome, Confirmed if other is None else Contradicted)
    assert len(home.commands) == (2 if other is None else 6)


async def json_lamp(home: Home, command: Command) -> None:
    """Obey in one message with all values, as most lamps do: whatever is set turns it on."""
    is_on = command.value.plain() is not False
    await anyio.sleep(0.05)
    await home.gateway.devices.report("lamp", {"on_off": is_on, "level": 40.0, "color_temperature": 2700.0})


@pytest.mark.parametrize(("capability", "value"), [("level", 40.0), ("color_temperature", 2700.0)])
async def test_who_dims_a_lamp_soon_after_it_was_turned_off_made_it_no_liar(
    open_home: OpenHome, capability: str, value: PlainValue
) -> None:
    async with open_home(rate_limit=False) as home:
        lamp = await home.lamp("on_off", "level", "color_temperature", behaviour=json_lamp)
        for _ in range(6):
            for outcome in (await lamp.turn_off(), await lamp.command(capability, value)):
                assert isinstance(outcome, Confirmed)
                assert (outcome.evidence, round(outcome.latency, 2)) == (Evidence.REPORTED, 0.05)
        await anyio.sleep(20)
        assert home.events == []


async def test_a_blind_that_is_sent_half_up_soon_after_it_closed_did_not_go_back(home: Home) -> None:

    async def move(home: Home, command: Command) -> None:
        is_closed = command.value.plain() == "closed"
        movement, position = ("closed", 0.0) if is_closed else ("open", 50.0)
        await home.gateway.devices.report("blind", {"movement": movement, "position": position})

    blind = await home.new(WindowCovering, "blind", "movement", "position", behaviour=move)
    assert isinstance(await blind.close(), Confirmed)
    assert isinstance(await blind.set_position(50), Confirmed)
    await anyio.sleep(20)
    assert home.events == []


async def test_a_lamp_that_is_turned_off_is_told_no_older_colour_again(home: Home) -> None:
    """Nor the other way round: a colour turns it on."""
    lamp = await home.lamp("on_off", "color_temperature", behaviour=ignore)
    found = []
    for capability, value in (("color_temperature", 2700.0), ("on_off", False), ("color_temperature", 4000.0)):
        found.append(home.begin(partial(lamp.command, capability, value)))
        await anyio.sleep(1)
    await anyio.sleep(20)
    assert [type(one) for (one,) in found] == [Superseded, Superseded, NoAnswer]
    told = [(one.capability, one.value.plain()) for one in home.commands]
    assert told == [("color_temperature", 2700.0), ("on_off", False), *[("color_temperature", 4000.0)] * 3]


async def test_a_blind_that_is_not_known_to_move_is_stopped_all_the_same(home: Home) -> None:
    """It reports nothing on its way, and somebody may have started it at its switch."""
    await (await home.new(WindowCovering, "blind", "movement", before={"movement": "open"})).stop()
    assert [one.value.plain() for one in home.commands][:1] == ["stopped"]


async def test_the_latch_of_an_unlocked_door_is_opened(open_home: OpenHome) -> None:
    async with open_home(always_ask=False) as home:
        door = await home.new(DoorLock, "door", "lock", before={"lock": "unlocked"})
        assert isinstance(await door.unlock(), AlreadySo)
        assert isinstance(await door.open(), Confirmed)
        assert [one.value.plain() for one in home.commands] == ["open"]


async def test_a_dimmer_without_a_switch_is_told_a_level_of_0(home: Home) -> None:
    lamp = await home.new(Light, "lamp", "level", readable=("on_off",), before={"on_off": True, "level": 100.0})
    assert isinstance(await lamp.command("level", 0.0), Confirmed)
    await home.report("lamp", "on_off", False)
    assert isinstance(await lamp.command("level", 0.0), AlreadySo)
    assert [(one.capability, one.value.plain()) for one in home.commands] == [("level", 0.0)]


async def test_what_is_so_already_is_not_sent(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", before={"on_off": True})
    assert isinstance(await lamp.turn_on(), AlreadySo)
    assert home.commands == []


async def test_a_lamp_that_came_back_is_told_again(home: Home) -> None:
    """It may have lost its power, and come back as something else without a report."""
    home.put("lamp", "light", "on_off")
    home.gateway.devices.report_reachable("lamp", reachable=True)
    await anyio.sleep(1)
    await home.report("lamp", "on_off", True)
    lamp = await home.handle(Light)
    assert isinstance(await lamp.turn_on(), AlreadySo)
    for reachable in (False, True):
        home.gateway.devices.report_reachable("lamp", reachable=reachable)
        await anyio.sleep(1)
    assert home.commands == []
    assert isinstance(await lamp.turn_on(), Confirmed)
    assert [one.value.plain() for one in home.commands] == [True]
    assert isinstance(await lamp.turn_on(), AlreadySo)
    assert len(home.commands) == 1


async def test_a_lamp_that_is_offline_is_not_what_it_was(home: Home) -> None:
    """A Tasmota plug that was pulled out within a minute of its report was said to be on already."""
    lamp = await home.lamp("on_off", before={"on_off": True})
    home.behaviours["lamp"] = ignore
    home.gateway.devices.report_reachable("lamp", reachable=False)
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_on(), NoAnswer)


async def test_what_was_so_long_ago_is_sent_and_silence_does_not_contradict_it(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": True})
    await anyio.sleep(300)
    home.behaviours["lamp"] = ignore
    assert isinstance(await lamp.turn_on(), AlreadySo)
    assert home.commands


@pytest.mark.parametrize(("reachable", "expected"), [(True, AlreadySo), (None, NoAnswer), (False, NoAnswer)])
async def test_a_switch_that_is_online_and_reports_only_changes_is_as_the_broker_kept_it(
    home: Home, *, reachable: bool | None, expected: type[Outcome]
) -> None:
    """As ESPHome's and ESPurna's: told to be on where they are on, they report nothing."""
    relay = await home.new(Switch, "relay", "on_off", behaviour=ignore)
    await home.gateway.devices.report("relay", {"on_off": True}, retained=True)
    home.gateway.devices.report_reachable("relay", reachable=reachable)
    await anyio.sleep(1)
    assert isinstance(await relay.turn_on(), expected)
    assert len(home.commands) == 3
    assert isinstance(await relay.turn_off(), NoAnswer)


async def test_what_was_so_before_a_command_without_an_answer_is_not_known_any_more(home: Home) -> None:
    """The lamp may have obeyed, and its report was lost."""
    lamp = await home.lamp("on_off")
    assert isinstance(await lamp.turn_on(), Confirmed)
    home.behaviours["lamp"] = ignore
    assert isinstance(await lamp.turn_off(), NoAnswer)
    sent = len(home.commands)
    assert isinstance(await lamp.turn_on(), NoAnswer)
    assert len(home.commands) > sent
    await anyio.sleep(1)
    await home.report("lamp", "on_off", True)
    await anyio.sleep(1)
    sent = len(home.commands)
    assert isinstance(await lamp.turn_on(), AlreadySo)
    assert len(home.commands) > sent  # it may repeat what it reported before
    home.behaviours["lamp"] = obey
    assert isinstance(await lamp.turn_on(), Confirmed)
    sent = len(home.commands)
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_on(), AlreadySo)
    assert len(home.commands) == sent


async def test_a_lamp_that_contradicted_a_command_is_as_it_said(home: Home) -> None:
    """Home Assistant sends no equal state: only the older report says that the lamp is off."""
    lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=report((0.2, False)))
    assert isinstance(await lamp.turn_on(), Contradicted)
    home.behaviours["lamp"] = ignore
    sent = len(home.commands)
    assert isinstance(await lamp.turn_off(), AlreadySo)
    assert len(home.commands) > sent  # it may obey the first command late


async def test_a_lamp_that_reports_nothing_is_acknowledged_at_most(home: Home) -> None:
    outcome = await (await home.new(Switch, "plug", "on_off", is_silent=True)).turn_on()
    assert isinstance(outcome, Confirmed)
    assert outcome.evidence is Evidence.ACKNOWLEDGED


async def test_a_blind_on_its_way_is_waited_for(home: Home) -> None:
    outcome = await (
        await home.new(WindowCovering, "blind", "movement", behaviour=report((1.0, "opening"), (45.0, "open")))
    ).open()
    assert isinstance(outcome, Confirmed)
    assert round(outcome.latency) == 45
    assert len(home.commands) == 1


async def test_a_blind_of_which_nothing_was_heard_since_it_began_to_move_gave_no_answer(home: Home) -> None:
    """Its last report may have been lost."""
    outcome = await (await home.new(WindowCovering, "blind", "movement", behaviour=report((1.0, "opening")))).open()
    assert outcome == NoAnswer(61.0, command_id=outcome.command_id)


async def test_what_was_so_before_a_command_that_is_on_its_way_is_not_known(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": True}, behaviour=ignore)
    outcomes = home.begin(lamp.turn_off)
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_on(), NoAnswer)
    assert [type(one) for one in outcomes] == [Superseded]
    await anyio.sleep(1)
    home.behaviours["lamp"] = obey
    await lamp.turn_on()
    await anyio.sleep(70)
    home.behaviours["lamp"] = ignore
    outcomes = home.begin(lamp.turn_on)  # which wants the same
    assert isinstance(await lamp.turn_on(), Superseded)
    await anyio.sleep(20)
    assert [type(one) for one in outcomes] == [AlreadySo]


async def blind_without_movement(home: Home) -> WindowCovering:
    """Put a blind that takes movements, and reports its position alone; it is open."""
    return await home.new(
        WindowCovering, "blind", "movement", "position", is_write_only=("movement",), before={"position": 100.0}
    )


def positions(*values: tuple[float, float]) -> Behaviour:
    """Report each position so many seconds after the command, whatever it was."""

    async def behaviour(home: Home, command: Command) -> None:
        for seconds, position in values:
            home.later(seconds, command.key, "position", position)

    return behaviour


async def test_a_blind_that_reports_its_position_alone_is_known_by_that(home: Home) -> None:
    blind = await blind_without_movement(home)
    home.behaviours["blind"] = positions((5.0, 60.0), (20.0, 0.0))
    outcome = await blind.close()
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), outcome.evidence) == (20, Evidence.REPORTED)
    home.behaviours["blind"] = positions((2.0, 0.0))
    assert isinstance(await blind.open(), Contradicted)
    assert isinstance(await blind.stop(), Confirmed)


async def test_a_blind_that_goes_back_is_told_as_an_event(home: Home) -> None:
    """As behind a bridge that reports the commanded position before the blind has moved."""
    blind = await blind_without_movement(home)
    home.behaviours["blind"] = positions((0.0, 0.0), (4.0, 100.0))
    for command in (blind.close, partial(blind.set_position, 0.0)):
        home.events.clear()
        outcome = await command()
        assert isinstance(outcome, Confirmed)
        await anyio.sleep(16)
        assert [one.result.command_id for one in home.events] == [outcome.command_id]


async def test_a_blind_that_tells_where_it_will_be_and_then_each_step_does_not_go_back(home: Home) -> None:
    blind = await blind_without_movement(home)
    steps = [(0.0, 0.0), (0.5, 100.0), *((3.0 + number, 95.0 - 5 * number) for number in range(20))]
    home.behaviours["blind"] = positions(*steps)
    assert isinstance(await blind.close(), Confirmed)
    await anyio.sleep(60)
    assert home.events == []


@pytest.mark.parametrize("failing", ["movement", "position"])
async def test_after_a_failed_command_an_older_report_of_the_same_in_other_words_counts_no_more(
    home: Home, failing: str
) -> None:
    blind = await blind_without_movement(home)
    home.behaviours["blind"] = ignore  # it may have obeyed, and its report was lost
    assert isinstance(await (blind.close() if failing == "movement" else blind.set_position(0.0)), NoAnswer)
    home.commands.clear()
    assert isinstance(await (blind.set_position(100.0) if failing == "movement" else blind.open()), NoAnswer)
    assert home.commands


async def test_after_an_unanswered_off_an_older_level_counts_no_more(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", before={"on_off": True, "level": 80.0}, behaviour=ignore)
    assert isinstance(await lamp.turn_off(), NoAnswer)
    home.commands.clear()
    assert isinstance(await lamp.set_level(80.0), NoAnswer)
    assert home.commands


async def test_a_lock_that_jams_on_its_way_is_soon_contradicted_each_time(home: Home) -> None:
    lock = await home.new(DoorLock, "lock", "lock", behaviour=report((1.0, "locking"), (4.0, "jammed")))
    for _ in range(2):
        began = anyio.current_time()
        outcome = await lock.lock()
        assert isinstance(outcome, Contradicted)
        assert outcome.saw == "lock is jammed"
        assert anyio.current_time() - began < 20


async def test_a_lock_that_tries_again_after_a_jam_is_awaited(home: Home) -> None:
    behaviour = report((1.0, "locking"), (4.0, "jammed"), (9.0, "locking"), (30.0, "locked"))
    assert isinstance(await (await home.new(DoorLock, "lock", "lock", behaviour=behaviour)).lock(), Confirmed)


async def test_an_alarm_that_is_disarmed_while_it_arms_is_soon_contradicted(home: Home) -> None:
    alarm = await home.new(
        Handle,
        "alarm",
        "alarm",
        service_type="x_alarm_panel",
        before={"alarm": "disarmed"},
        behaviour=report((0.5, "arming"), (6.0, "disarmed")),
    )
    began = anyio.current_time()
    assert isinstance(await alarm.command("alarm", "armed_away"), Contradicted)
    assert anyio.current_time() - began < 20


async def test_a_newer_command_takes_the_place_of_the_older_one(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=obey_after(3.0))
    outcomes = home.begin(lamp.turn_on)
    await anyio.sleep(1)
    last = await lamp.turn_off()
    assert isinstance(last, Confirmed)
    (first,) = outcomes
    assert first == Superseded(last.command_id, command_id=first.command_id)


async def test_off_takes_the_place_of_a_level_that_would_be_sent_again(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", behaviour=ignore)
    outcomes = home.begin(partial(lamp.set_level, 40))
    await anyio.sleep(1)
    home.behaviours["lamp"] = obey
    last = await lamp.turn_off()
    assert isinstance(last, Confirmed)
    await anyio.sleep(60)
    assert outcomes == [Superseded(last.command_id, command_id=outcomes[0].command_id)]
    assert [(one.capability, one.value.plain()) for one in home.commands] == [("level", 40.0), ("on_off", False)]


@pytest.mark.parametrize("newer", ["closed", "stopped"])
async def test_a_movement_takes_the_place_of_a_position(home: Home, newer: str) -> None:
    blind = await home.new(WindowCovering, "blind", "movement", "position", behaviour=ignore)
    outcomes = home.begin(partial(blind.set_position, 100))
    await anyio.sleep(1)
    await (blind.close() if newer == "closed" else blind.stop())
    await anyio.sleep(60)
    assert isinstance(outcomes[0], Superseded)
    assert [one.capability for one in home.commands].count("position") == 1


async def test_on_lets_a_level_go_on(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", behaviour=obey_after(0.5))
    outcomes = home.begin(partial(lamp.set_level, 40))
    await anyio.sleep(0.1)
    assert isinstance(await lamp.turn_on(), Confirmed)
    await anyio.sleep(1)
    assert isinstance(outcomes[0], Confirmed)


async def test_a_dimmer_may_round(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", behaviour=report((0.2, 39.6)))
    assert (await lamp.set_level(40)).succeeded


@pytest.mark.parametrize(("kind", "mode"), [("fan", "fan_mode"), ("thermostat", "thermostat_mode")])
async def test_a_device_that_is_given_a_mode_soon_after_it_was_turned_off_is_no_liar(
    home: Home, kind: str, mode: str
) -> None:
    async def run(home: Home, command: Command) -> None:
        wanted = command.value.plain() if command.capability == mode else "off"
        await home.gateway.devices.report("device", {"on_off": wanted != "off", mode: wanted})

    device = await home.new(Handle, "device", "on_off", mode, service_type=kind, behaviour=run)
    assert isinstance(await device.command(mode, "cool"), Confirmed)
    assert isinstance(await device.command("on_off", False), Confirmed)
    assert isinstance(await device.command(mode, "auto"), Confirmed)
    await anyio.sleep(20)
    assert home.events == []


SMALL_STEPS = [
    ("thermostat", "heating_setpoint", 21.0, 21.5),
    ("light", "level", 40.16, 41.0),
    ("x_setting", "number", 0.5, 0.9),
]


@pytest.mark.parametrize(("kind", "capability", "before", "wanted"), SMALL_STEPS)
async def test_half_a_degree_more_is_commanded_although_a_device_may_round_by_as_much(
    home: Home, kind: str, capability: str, before: float, wanted: float
) -> None:
    device = await home.new(Handle, "device", capability, service_type=kind)
    await home.report("device", capability, before)
    await anyio.sleep(1)
    assert isinstance(await device.command(capability, wanted), Confirmed)
    assert [one.value.plain() for one in home.commands] == [wanted]
    assert isinstance(await device.command(capability, wanted), AlreadySo)


@pytest.mark.parametrize(("kind", "capability", "before", "wanted"), SMALL_STEPS)
async def test_who_reports_the_setpoint_from_before_did_not_take_half_a_degree_more(
    home: Home, kind: str, capability: str, before: float, wanted: float
) -> None:
    device = await home.new(Handle, "device", capability, service_type=kind, behaviour=report((0.2, before)))
    await home.report("device", capability, before)
    await anyio.sleep(1)
    assert isinstance(await device.command(capability, wanted), Contradicted)


@pytest.mark.parametrize(("wanted", "reported"), [(21.3, 21.5), (21.4, 21.667)])
async def test_a_thermostat_that_rounds_is_told_the_same_once(home: Home, wanted: float, reported: float) -> None:
    """It takes half degrees, or whole ones of Fahrenheit."""
    radiator = await home.new(Thermostat, "radiator", "heating_setpoint", behaviour=report((0.2, reported)))
    assert isinstance(await radiator.heat_to(wanted), Confirmed)
    assert isinstance(await radiator.heat_to(wanted), AlreadySo)


@pytest.mark.parametrize(
    ("kind", "capability", "wanted", "reported"),
    [
        ("fan", "fan_speed", 50.0, 66.0),
        ("fan", "fan_speed", 34.0, 66.67),
        ("fan", "fan_speed", 20.0, 33.0),
        ("fan", "fan_speed", 60.0, 67.0),
        ("fan", "fan_speed", 60.0, 75.0),
        ("light", "color", (120.0, 100.0), (136.0, 100.0)),
        ("light", "color", (180.0, 100.0), (180.0, 78.0)),
        ("light", "color", (300.0, 100.0), (300.0, 96.0)),
        ("thermostat", "cooling_setpoint", 21.5, 22.0),
    ],
)
@pytest.mark.parametrize("is_told_first", [False, True])
async def test_a_device_that_does_the_nearest_that_it_can_obeyed_each_time(
    home: Home, kind: str, capability: str, wanted: PlainValue, reported: PlainValue, *, is_told_first: bool
) -> None:
    """Fans of three and four speeds, lamps of Philips Hue that show no vivid green, and an air conditioner.

    Zigbee2MQTT reports the commanded value first, and then what the device reads back.
    """
    home.put("device", kind, capability)
    first = [(0.05, wanted)] if is_told_first else []
    home.behaviours["device"] = report(*first, (0.2, reported))
    device = await home.handle(Handle)
    assert isinstance(await device.command(capability, wanted), Confirmed)
    await anyio.sleep(20)
    assert isinstance(await device.command(capability, wanted), AlreadySo)
    await anyio.sleep(100)
    assert isinstance(await device.command(capability, wanted), Confirmed)
    await anyio.sleep(20)
    assert home.events == []


@pytest.mark.parametrize(
    ("kind", "capability", "wanted", "reported"),
    [
        ("fan", "fan_speed", 50.0, 33.0),
        ("fan", "fan_speed", 30.0, 100.0),
        ("fan", "fan_speed", 0.0, 33.0),
        ("light", "color", (120.0, 100.0), (60.0, 100.0)),
        ("light", "color", (120.0, 60.0), (140.0, 60.0)),
        ("light", "color", (120.0, 100.0), (120.0, 20.0)),
    ],
)
async def test_a_device_that_does_something_else_did_not_obey(
    home: Home, kind: str, capability: str, wanted: PlainValue, reported: PlainValue
) -> None:
    assert isinstance(
        await (
            await home.new(Handle, "device", capability, service_type=kind, behaviour=report((0.2, reported)))
        ).command(capability, wanted),
        Contradicted,
    )


async def test_what_a_hand_changed_by_half_a_degree_is_commanded_again(home: Home) -> None:
    """It is no rounding of the same command from before."""
    radiator = await home.new(Thermostat, "radiator", "heating_setpoint")
    assert isinstance(await radiator.heat_to(21.5), Confirmed)
    await anyio.sleep(100)
    await home.report("radiator", "heating_setpoint", 21.0)
    await anyio.sleep(1)
    assert isinstance(await radiator.heat_to(21.5), Confirmed)
    assert len(home.commands) == 2


@pytest.mark.parametrize(
    ("older", "newer"),
    [
        (("color", (120.0, 80.0)), ("color_temperature", 2700.0)),
        (("color_temperature", 2700.0), ("color", (9.0, 80.0))),
    ],
)
async def test_white_takes_the_place_of_a_colour_and_no_lamp_went_back(
    home: Home, older: tuple[str, PlainValue], newer: tuple[str, PlainValue]
) -> None:
    """A lamp that shows one of them reports that the other is unknown, or what it looks like."""

    async def show(home: Home, command: Command) -> None:
        other = "color" if command.capability == "color_temperature" else "color_temperature"
        await home.gateway.devices.report("lamp", {command.capability: command.value.plain(), other: None})

    lamp = await home.lamp("on_off", "color_temperature", "color", behaviour=show)
    assert isinstance(await lamp.command(*older), Confirmed)
    assert isinstance(await lamp.command(*newer), Confirmed)
    await anyio.sleep(20)
    assert home.events == []


async def test_several_settings_are_one_command(home: Home) -> None:
    lamp = await home.lamp("on_off", "level", "color_temperature")
    assert isinstance(await lamp.turn_on(level=40, kelvin=2700), Confirmed)
    assert [one.capability for one in home.commands] == ["level", "color_temperature"]


async def test_a_gateway_that_only_observes_refuses(home: Home) -> None:
    home.put("lamp", "light", "on_off")
    home.gateway.acts = False
    outcome = await (await home.handle(Light)).turn_on()
    assert isinstance(outcome, Refused)
    assert outcome.policy == "gateway"
    assert "only observes" in outcome.reason


async def test_a_network_that_is_away_is_told(home: Home) -> None:
    lamp = await home.lamp("on_off")
    home.gateway.set_unavailable("the cable is out")
    outcome = await lamp.turn_on()
    assert isinstance(outcome, NoAnswer)
    assert "the cable is out" in outcome.text


async def test_a_device_that_was_removed_is_gone(home: Home) -> None:
    lamp = await home.lamp("on_off")
    home.gateway.devices.remove("lamp", "sold")
    await anyio.sleep(1)
    assert isinstance(await lamp.turn_on(), Gone)


async def test_a_text_to_an_unknown_device_is_refused_with_its_id_as_a_command_by_values_is(home: Home) -> None:
    request = SendTextRequest(device="nosuch", payload="on", issuer="/app")
    response = await home.app.create_client(SendText, SEND_TEXT).call(request)
    (_, outcome) = (await home.read(device="nosuch")).entries
    assert response.message == outcome.results[0].text == "there is no device with the id nosuch"


async def test_a_device_that_is_removed_before_it_answers_is_gone(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=report())
    outcomes: list[Outcome] = []

    async def turn_on() -> None:
        outcomes.append(await lamp.turn_on())

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(turn_on)
        await anyio.sleep(1)
        home.gateway.devices.remove("lamp", "sold")
    assert [type(one) for one in outcomes] == [Gone]


async def test_a_part_that_can_do_more_than_before_confirms_that_too(home: Home) -> None:
    """What it reports of a capability that it had not at its first command was not heard."""
    thermostat = await home.new(Thermostat, "warm", "heating_setpoint")
    assert isinstance(await thermostat.command("heating_setpoint", 20.0), Confirmed)
    home.put("warm", "thermostat", "heating_setpoint", "cooling_setpoint")
    thermostat = await home.handle(Thermostat)
    assert isinstance(await thermostat.command("cooling_setpoint", 25.0), Confirmed)
    assert len(home.commands) == 2


async def test_a_device_that_its_gateway_has_just_lost_is_gone_and_was_not_refused(home: Home) -> None:
    async def vanish(home: Home, command: Command) -> None:
        home.gateway.devices.remove(command.key, "its announcement has run out")
        raise RefusedError("the command", "no device was announced with that key")

    lamp = await home.lamp("on_off", behaviour=vanish)
    assert isinstance(await lamp.turn_on(), Gone)


async def test_a_lamp_that_goes_back_is_told_as_an_event(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=report((0.1, True), (3.1, False)))
    outcome = await lamp.turn_on()
    assert isinstance(outcome, Confirmed)
    await anyio.sleep(5)
    (event,) = home.events
    assert (event.result.outcome, round(event.result.latency), event.issuer) == ("reverted", 3, "/app")
    assert event.result.command_id == outcome.command_id
    assert event.result.text == "changed back after 3 s, by hand or by itself"


async def test_a_value_that_is_lost_did_not_go_back(home: Home) -> None:
    """A player of Home Assistant that is off says no more whether it is muted."""
    lamp = await home.lamp("on_off", behaviour=report((0.1, True), (3.1, None)))
    assert isinstance(await lamp.turn_on(), Confirmed)
    await anyio.sleep(5)
    assert not home.events


async def test_a_value_that_is_lost_answers_nothing(home: Home) -> None:
    """Nor did a person take it away, as far as is known: a player that wakes up tells none, and one that is off."""
    lamp = await home.lamp("on_off", behaviour=report((0.1, None), (1.0, True)))
    with capture_logs() as lines:
        outcome = await lamp.turn_on()
        await anyio.sleep(60)
        await home.report("lamp", "on_off", None)
        await anyio.sleep(5)
    assert isinstance(outcome, Confirmed)
    assert round(outcome.latency) == 1
    assert [line["event"] for line in lines] == ["control.command"]


@pytest.mark.parametrize(
    ("levels", "reverted_after"),
    [
        (((1.0, 35.0), (2.0, 60.0), (4.0, 80.0)), None),
        (((1.0, 35.0), (2.0, 60.0), (11.0, 80.0)), None),
        (((1.0, 35.0), (2.0, 60.0)), 14),  # it stays there
        (((1.0, 35.0), (2.0, 20.0)), 2),
        (((3.0, 90.0),), 3),
    ],
)
async def test_a_dimmer_that_tells_where_it_will_be_and_then_each_step_does_not_go_back(
    home: Home, levels: tuple[tuple[float, float], ...], reverted_after: int | None
) -> None:
    lamp = await home.lamp("level", before={"level": 20.0})

    async def dim(home: Home, command: Command) -> None:
        await obey(home, command)
        for seconds, level in levels:
            home.later(seconds, "lamp", "level", level)

    home.behaviours["lamp"] = dim
    assert isinstance(await lamp.set_level(80.0, transition=4.0), Confirmed)
    began = anyio.current_time()
    reverted: list[int] = []
    while anyio.current_time() < began + 20:
        await anyio.sleep(0.5)
        if home.events and not reverted:
            reverted.append(int(anyio.current_time() - began))
    assert reverted == ([] if reverted_after is None else [reverted_after])


@pytest.mark.parametrize("fades", [True, False])
async def test_a_transition_that_a_lamp_does_not_take_is_told(home: Home, *, fades: bool) -> None:
    lamp = await home.lamp("on_off", "level", fades=fades)
    outcome = await lamp.set_level(80.0, transition=4.0)
    assert isinstance(outcome, Confirmed)
    assert outcome.warning == ("" if fades else "it takes no transition")
    assert outcome.text.endswith(outcome.warning)
    assert (await lamp.set_level(20.0)).warning == ""


Fade: TypeAlias = list[tuple[float, dict[str, PlainValue]]]

FADES_UP: Fade = [(0.1, {"on_off": True, "level": 100.0})]
FADES_UP += [(float(step), {"level": 25.0 * step}) for step in range(1, 5)]
"""A Philips Hue lamp in Zigbee2MQTT: what was commanded, and then each step."""

FADES_DOWN: Fade = [(0.1, {"on_off": False})]
FADES_DOWN += [(float(step), {"on_off": step < 4, "level": 100.0 - 20 * step}) for step in range(1, 5)]

FADES_DOWN_LATE: Fade = [(0.1, {"on_off": False}), (1.0, {"on_off": True}), (4.6, {"on_off": False})]


@pytest.mark.parametrize(
    ("was_on", "setting", "transition", "steps", "reverted"),
    [
        (False, ("level", 100.0), 4.0, FADES_UP, 0),
        (False, ("level", 100.0), 0.0, FADES_UP, 0),  # by a transition that is set in the bridge
        (True, ("on_off", False), 4.0, FADES_DOWN, 0),
        (True, ("on_off", False), 4.0, FADES_DOWN_LATE, 0),  # its last step comes after the transition
        (True, ("on_off", False), 0.0, FADES_DOWN, 0),  # likewise
        (True, ("on_off", False), 0.0, FADES_DOWN[:-1], 1),
        (True, ("on_off", False), 4.0, FADES_DOWN[:-1], 1),
    ],
)
async def test_a_lamp_that_reports_the_end_of_a_fade_first_and_then_its_steps_does_not_go_back(
    home: Home, *, was_on: bool, setting: tuple[str, PlainValue], transition: float, steps: Fade, reverted: int
) -> None:
    lamp = await home.lamp("on_off", "level")
    await home.gateway.devices.report("lamp", {"on_off": was_on, "level": 100.0})
    await anyio.sleep(1)

    async def tell(seconds: float, values: dict[str, PlainValue]) -> None:
        await anyio.sleep(seconds)
        await home.gateway.devices.report("lamp", values)

    async def fade(home: Home, _: Command) -> None:
        for step in steps:
            home.tasks.start_soon(tell, *step)

    home.behaviours["lamp"] = fade
    assert isinstance(await lamp.command(*setting, transition=transition), Confirmed)
    await anyio.sleep(30)
    assert len(home.events) == reverted


@pytest.mark.parametrize(
    ("settable", "transition", "reported", "reverted_after"),
    [
        (("on_off",), 0.1, {"on_off": True}, 1.0),
        (("on_off", "level"), 0.1, {"on_off": True, "level": 100.0}, 1.0),
        (("on_off", "level"), 0.1, {"on_off": True}, 2.0),  # a lower level may follow
        (("on_off", "level"), 4.0, {"on_off": True}, 5.0),  # or after the end of the transition
    ],
)
async def test_a_lamp_that_is_on_again_went_back_when_no_fade_can_explain_it(
    home: Home, settable: tuple[str, ...], transition: float, reported: dict[str, PlainValue], reverted_after: float
) -> None:
    """A lease would take a person's hand for a step of the transition."""
    lamp = await home.lamp(*settable, before={one: {"on_off": True, "level": 100.0}[one] for one in settable})
    assert isinstance(await lamp.command("on_off", False, transition=transition), Confirmed)
    await anyio.sleep(1.0)
    await home.gateway.devices.report("lamp", reported)
    await anyio.sleep(20)
    assert [one.result.latency for one in home.events] == [pytest.approx(reverted_after, abs=0.01)]


async def test_a_whole_floor_is_confirmed_at_once(home: Home) -> None:
    for number in range(200):
        home.put(f"lamp{number}", "light", "on_off")
        home.behaviours[f"lamp{number}"] = obey_after(1.0)
    outcomes: list[Outcome] = []

    async def turn_on(lamp: Light) -> None:
        outcomes.append(await lamp.turn_on())

    began = anyio.current_time()
    async with anyio.create_task_group() as tasks:
        await home.handle(Light, "lamp0")
        for lamp in await home.devices.find(Light):
            tasks.start_soon(turn_on, lamp)
    assert anyio.current_time() - began < 1.5
    assert len(outcomes) == 200
    assert all(isinstance(one, Confirmed) for one in outcomes)


async def test_a_lamp_that_is_about_to_change_is_told_although_it_is_still_so(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=obey_after(2.0))
    home.tasks.start_soon(lamp.turn_on)
    await anyio.sleep(1)
    await lamp.turn_off()
    assert [one.value.plain() for one in home.commands][:2] == [True, False]


async def test_of_several_settings_each_must_be_reported(home: Home) -> None:
    """Not the first alone."""

    async def obey_the_first(home: Home, command: Command) -> None:
        if command.capability == "on_off":
            await home.report(command.key, command.capability, command.value.plain())

    lamp = await home.lamp("on_off", "level", behaviour=obey_the_first)
    assert isinstance(await lamp.commands({"on_off": True, "level": 40.0}), NoAnswer)


@pytest.mark.parametrize("count", [0, 21])
async def test_a_command_has_one_to_twenty_settings(home: Home, count: int) -> None:
    home.put("lamp", "light", "on_off")
    with pytest.raises(RefusedError, match=f"{count} settings"):
        await (await home.handle(Light)).commands({f"x_{number}": 1.0 for number in range(count)})


def take_seconds(seconds: float) -> Behaviour:
    """Obey once the gateway has a connection to the device."""

    async def behaviour(home: Home, command: Command) -> None:
        await anyio.sleep(seconds)
        await obey(home, command)

    return behaviour


async def test_a_gateway_that_takes_long_to_connect_is_waited_for(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=take_seconds(7.0))
    outcome = await lamp.turn_on()
    assert isinstance(outcome, Confirmed)
    assert (round(outcome.latency), outcome.evidence) == (7, Evidence.REPORTED)


async def test_what_a_gateway_cannot_send_in_time_does_not_happen_later(home: Home) -> None:
    lamp = await home.lamp("on_off", behaviour=take_seconds(12.0))
    outcome = await lamp.turn_on()
    assert isinstance(outcome, NoAnswer)
    assert (outcome.waited, outcome.text) == (
        10,
        "not sent: on_off of lamp: lamp was not reached within 10 s",
    )
    await anyio.sleep(60)
    assert lamp.on is None


async def test_a_device_that_misses_the_first_sending_each_time_is_not_given_more_and_more_time(
    open_home: OpenHome,
) -> None:
    async with open_home(retries=1) as home:
        sent: list[str] = []

        async def miss_the_first(home: Home, command: Command) -> None:
            sent.append(command.id)
            if sent.count(command.id) == 2:
                await obey(home, command)

        lamp = await home.lamp("on_off", before={"on_off": False}, behaviour=miss_the_first)
        for number in range(16):
            outcome = await (lamp.turn_off() if number % 2 else lamp.turn_on())
            assert isinstance(outcome, Confirmed)
            assert outcome.latency < 16


async def test_what_a_device_reported_before_the_last_sending_contradicts_nothing(open_home: OpenHome) -> None:
    """The last one may have been obeyed, and its report lost."""
    async with open_home(retries=1) as home:

        async def say_once_how_it_was(home: Home, command: Command) -> None:
            if len(home.commands) == 1:
                home.later(1.0, "lamp", "on_off", False)

        lamp = await home.lamp("on_off", behaviour=say_once_how_it_was)
        outcome = await lamp.turn_on()
        assert outcome.text == "no answer within 10 s"


async def test_a_colour_of_a_lamp_that_stays_off_is_not_confirmed(home: Home) -> None:
    """``turn_on(kelvin=…)`` is about the light, not about the colour that it would have."""
    lamp = await home.lamp("on_off", "color_temperature", before={"on_off": False})
    outcome = await lamp.turn_on(kelvin=2700)
    assert not outcome.succeeded
    assert lamp.on is False
