"""Which reported values are certain, and whether a position opens or closes."""

import anyio
import pytest
from tests.control.conftest import Home, ignore
from tests.control.policies.houses import START, make_command, make_device, make_facts, new_timeline

from homebot.control.command import IssuedCommand, order_of
from homebot.control.timeline.facts import Decided, Sent
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices.handles import WindowCovering
from homebot.devices.outcomes import AlreadySo, Confirmed, Contradicted, Evidence, NoAnswer, Outcome, Refused
from homebot.devices.value import PlainValue
from homebot.words.patterns import read_pattern

BLIND = make_device("blind", "window_covering", settable=("movement", "position"))
DEVICE_AND_PART = (BLIND, BLIND.parts[0])


def position(wanted: float, *, at: float = 0.0, told: float = 0.0, name: str = "2") -> IssuedCommand:
    """A command for a position to a blind that reported *at* at *told*, in seconds since the start."""
    values: dict[str, PlainValue] = {"position": at}
    blind = make_device("blind", "window_covering", settable=("movement",), since=START + told, values=values)
    return make_command(blind, {"position": wanted}, name=name)


def sent(*commands: tuple[float, IssuedCommand]) -> PartTimeline:
    """A part to which commands were sent, each at so many seconds since the start."""
    timeline = new_timeline(*DEVICE_AND_PART)
    for at, command in commands:
        timeline.command(order_of(command), START + at)
        timeline.append(Sent(command.id, command.settings, START + at))
    return timeline


def moved(capability: str, value: PlainValue, at: float = 100.0) -> PartTimeline:
    """A blind to which one command was sent."""
    return sent((at, make_command(BLIND, {capability: value})))


def known(command: IssuedCommand, timeline: PartTimeline, now: float = 110.0) -> PlainValue:
    return make_facts(now=START + now, timeline=timeline).certain(command, "position")


def test_a_report_counts_where_nothing_was_sent_since() -> None:
    assert known(position(10.0, at=40.0), sent()) == 40.0


def test_a_report_from_before_a_command_counts_no_more() -> None:
    assert known(position(10.0), moved("movement", "open")) is None
    assert known(position(10.0), moved("position", 100.0)) is None
    assert known(position(10.0), moved("position", 100.0), now=10_000.0) is None


def test_a_report_from_the_way_there_does_not_count_for_five_minutes() -> None:
    on_its_way = position(10.0, at=20.0, told=105.0)
    assert known(on_its_way, moved("movement", "open")) is None
    assert known(on_its_way, moved("movement", "open"), now=399.0) is None
    assert known(on_its_way, moved("movement", "open"), now=401.0) == 20.0


def test_a_report_of_what_was_commanded_counts_at_once() -> None:
    assert known(position(10.0, at=100.0, told=105.0), moved("movement", "open")) == 100.0
    assert known(position(10.0, at=0.0, told=105.0), moved("movement", "closed")) == 0.0
    assert known(position(10.0, at=51.0, told=105.0), moved("position", 50.0)) == 51.0


def test_a_stopped_motor_may_be_anywhere() -> None:
    assert known(position(10.0, at=20.0, told=105.0), moved("movement", "stopped")) is None


def test_a_command_that_is_repeated_does_not_doubt_itself() -> None:
    command = position(70.0, at=40.0)
    assert known(command, sent((100.0, command))) == 40.0
    before = make_command(BLIND, {"position": 100.0})
    assert known(command, sent((50.0, before), (100.0, command))) is None


def test_a_position_that_is_not_known_is_both_opened_and_closed_by_a_command() -> None:
    facts = make_facts(now=START + 110.0, timeline=moved("position", 60.0))
    for verb in ("open", "close"):
        assert read_pattern(verb).fits(position(30.0), facts)


def test_the_end_of_the_way_is_closed_whatever_was_reported() -> None:
    """A hand may have opened it a moment ago."""
    facts = make_facts()
    assert read_pattern("close").fits(position(0.0, at=0.0), facts)
    assert not read_pattern("open").fits(position(0.0, at=0.0), facts)
    assert read_pattern("open").fits(position(100.0, at=100.0), facts)
    assert not read_pattern("close").fits(position(100.0, at=100.0), facts)


def test_a_setpoint_heats_where_a_lower_one_was_sent_meanwhile() -> None:
    thermostat = make_device("it", "thermostat", settable=("heating_setpoint",), values={"heating_setpoint": 25.0})
    heats = read_pattern("heat")
    command = make_command(thermostat, {"heating_setpoint": 20.0}, name="2")
    assert not heats.fits(command, make_facts(timeline=sent()))
    lowered = make_command(thermostat, {"heating_setpoint": 8.0})
    assert heats.fits(command, make_facts(timeline=sent((0.0, lowered))))


def ended(outcome: Outcome, *reports: tuple[float, float], is_raw: bool = False) -> PartTimeline:
    """A blind to which a command for 50 % was sent at 100 s; it reported positions, until the outcome at 160 s."""
    timeline, command = new_timeline(*DEVICE_AND_PART), make_command(BLIND, {"position": 50.0})
    timeline.command(order_of(command), START + 100.0, is_raw=is_raw)
    if not is_raw:
        timeline.append(Sent(command.id, command.settings, START + 100.0))
    for at, value in reports:
        timeline.report(START + at, START + at, "position", value)
    timeline.append(Decided(command.id, START + 160.0, outcome))
    timeline.advance(START + 200.0)
    return timeline


CONFIRMED = Confirmed(60.0, Evidence.REPORTED)


@pytest.mark.parametrize(
    ("timeline", "told", "now", "is_certain"),
    [
        pytest.param(ended(CONFIRMED, (110.0, 50.0)), 205.0, 210.0, True, id="a hand moved it after it had arrived"),
        pytest.param(ended(CONFIRMED), 205.0, 210.0, False, id="it never told that it arrived"),
        pytest.param(ended(CONFIRMED), 205.0, 401.0, True, id="it never did, and no motor runs for five minutes"),
        pytest.param(ended(NoAnswer(60.0)), 150.0, 5000.0, False, id="told before a command failed"),
        pytest.param(ended(NoAnswer(60.0)), 405.0, 410.0, True, id="told after that"),
        pytest.param(ended(Contradicted("closed")), 90.0, 5000.0, False, id="told before it was refused"),
        pytest.param(ended(Refused("gateway", "no")), 90.0, 170.0, True, id="the command did not reach it"),
        pytest.param(ended(NoAnswer(0.0), is_raw=True), 110.0, 210.0, False, id="a raw text may still have an effect"),
    ],
)
def test_a_report_is_certain_that_no_command_makes_doubtful(
    timeline: PartTimeline, told: float, now: float, *, is_certain: bool
) -> None:
    assert known(position(10.0, at=20.0, told=told), timeline, now) == (20.0 if is_certain else None)


def test_the_last_failure_is_kept_until_a_command_is_confirmed_and_no_older_one() -> None:
    """Hours later, and after more commands of others than are stored."""
    timeline, outcomes = new_timeline(*DEVICE_AND_PART), (NoAnswer(5.0), CONFIRMED)

    def play(at: float, name: str, outcome: Outcome, capability: str, value: PlainValue) -> None:
        command = make_command(BLIND, {capability: value}, name=name)
        timeline.command(order_of(command), START + at)
        timeline.append(Sent(command.id, command.settings, START + at))
        timeline.append(Decided(command.id, START + at + 5.0, outcome))

    for number in range(40):
        play(number * 20.0, f"position{number}", NoAnswer(5.0), "position", float(number))
    play(900.0, "closing", CONFIRMED, "movement", "closed")
    for number in range(400):
        play(1000.0 + number * 60.0, f"tilt{number}", outcomes[number % 2], "tilt", float(number % 100))
    asked = position(10.0, at=20.0, told=780.0)
    assert known(asked, timeline, 30_000.0) is None
    proofs = [timeline.last_proved(name) for name in ("position", "movement", "tilt")]
    assert [proof and proof.order.id for proof in proofs] == ["position39", "closing", "tilt399"]
    assert len(timeline.commands) < 20
    play(30_000.0, "opening", CONFIRMED, "position", 60.0)
    assert known(position(10.0, at=20.0, told=30_006.0), timeline, 40_000.0) == 20.0


@pytest.mark.virtual_time
async def test_a_blind_that_is_sent_where_it_is_on_its_way_to_elsewhere_is_commanded(home: Home) -> None:
    """It had told that it was open before it moved."""
    home.put("blind", "window_covering", "movement", "position")
    await home.gateway.devices.report("blind", {"movement": "closed", "position": 0.0})
    await anyio.sleep(1)
    blind = await home.handle(WindowCovering)
    assert isinstance(await blind.open(), Confirmed)
    await home.report("blind", "position", 40.0)
    home.later(1.0, "blind", "position", 40.0)
    assert isinstance(await blind.set_position(40.0), Confirmed)
    assert [one.value.plain() for one in home.commands] == ["open", 40.0]


@pytest.mark.virtual_time
async def test_a_lamp_is_commanded_to_a_level_at_which_it_is_during_a_transition(home: Home) -> None:
    """Many bridges tell the end of a transition at its beginning."""
    lamp = await home.lamp("on_off", "level", before={"on_off": True, "level": 0.0})
    assert isinstance(await lamp.command("level", 100.0, transition=60.0), Confirmed)
    await anyio.sleep(20)
    await home.report("lamp", "level", 40.0)
    assert isinstance(await lamp.command("level", 40.0), Confirmed)
    assert [one.value.plain() for one in home.commands] == [100.0, 40.0]


@pytest.mark.virtual_time
async def test_a_lamp_is_commanded_after_a_raw_text_that_it_did_not_report(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": True}, behaviour=ignore)
    await home.devices.tell(lamp.device, "off")
    await lamp.turn_on()
    assert home.commands[-1].value.plain() is True


@pytest.mark.virtual_time
async def test_what_a_hand_did_is_so_already_while_nothing_else_is_on_its_way(home: Home) -> None:
    lamp = await home.lamp("on_off", before={"on_off": False})
    assert isinstance(await lamp.turn_on(), Confirmed)
    await anyio.sleep(30)
    await home.report("lamp", "on_off", False)
    assert isinstance(await lamp.turn_off(), AlreadySo)
    assert len(home.commands) == 1
