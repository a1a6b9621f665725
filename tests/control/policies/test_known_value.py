"""What a part is known to be at, and whether a position opens or closes; pure."""

from tests.control.policies.houses import START, make_command, make_device, make_facts, new_timeline

from homebot.control.command import IssuedCommand, order_of
from homebot.control.policies.command_pattern import known_value, read_pattern
from homebot.control.timeline.facts import Sent
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices.value import PlainValue

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
    return known_value(command, "position", make_facts(now=START + now, timeline=timeline))


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
