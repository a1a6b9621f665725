"""Causes and outcomes against a simulated truth: whose doing each report was, and who is overridden.

The floors are the figures that a rule may not fall below; the tables are printed with ``pytest -s``.
"""

from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.control.timeline.simulated_parts import Kind, Report, Result, SimulatedPart

from homebot.control.timeline.facts import Cause, Transmission
from homebot.control.timeline.goal import Motion, WantedValue
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.control.timeline.profile import DeviceProfile
from homebot.control.timeline.progress import CommandProgress
from homebot.devices.value import PlainValue

ON_OFF: tuple[PlainValue, ...] = (False, True)
LEVELS: tuple[PlainValue, ...] = (10.0, 35.0, 60.0, 85.0)
POSITIONS: tuple[PlainValue, ...] = (0.0, 30.0, 70.0, 100.0)

OWN = (Cause.COMMAND, Cause.TRANSITION)


def number(value: PlainValue) -> float:
    assert isinstance(value, float)
    return value


def fast(random: Random, _before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(random.uniform(0.02, 0.4), "on_off", wanted, "command")]


def slow(random: Random, _before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(random.uniform(1.0, 8.0), "on_off", wanted, "command")]


def repeating(random: Random, _before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(random.uniform(0.02, 0.3) + number, "on_off", wanted, "command") for number in range(3)]


def deaf_now_and_then(random: Random, before: PlainValue, wanted: PlainValue) -> list[Report]:
    return fast(random, before, wanted) if random.random() < 0.7 else []


def by_timer(random: Random, before: PlainValue, wanted: PlainValue) -> list[Report]:
    obeyed = fast(random, before, wanted)
    return [*obeyed, (obeyed[0][0] + 4.0, "on_off", False, "device")] if wanted else obeyed


def echoing(random: Random, _before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(0.01, "on_off", wanted, "echo"), (random.uniform(0.3, 1.5), "on_off", wanted, "command")]


def dead_behind_an_echo(_random: Random, before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(0.01, "on_off", wanted, "echo"), (1.5, "on_off", before, "device")]


def ramp(
    before: PlainValue, wanted: PlainValue, capability: str, begin: float, step: float, steps: int
) -> list[Report]:
    low, high = number(before), number(wanted)
    values = [round(low + (high - low) * part / steps, 1) for part in range(1, steps + 1)]
    return [(begin + step * at, capability, value, "command") for at, value in enumerate(values)]


def fading(random: Random, before: PlainValue, wanted: PlainValue) -> list[Report]:
    return ramp(before, wanted, "level", 0.2, random.uniform(0.3, 1.0), 5)


def end_first(random: Random, before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(0.05, "level", wanted, "command"), *ramp(before, wanted, "level", 0.5, random.uniform(0.3, 1.0), 5)]


def rounding(random: Random, _before: PlainValue, wanted: PlainValue) -> list[Report]:
    return [(random.uniform(0.1, 0.5), "level", 10.0 * round(number(wanted) / 10.0), "command")]


def blind(random: Random, before: PlainValue, wanted: PlainValue) -> list[Report]:
    return ramp(before, wanted, "position", 1.0, random.uniform(1.0, 3.0), 8)


KINDS = (
    Kind("fast", "on_off", ON_OFF, fast),
    Kind("rejected", "on_off", ON_OFF, fast, follows=0.75),
    Kind("slow", "on_off", ON_OFF, slow),
    Kind("repeating", "on_off", ON_OFF, repeating),
    Kind("lossy", "on_off", ON_OFF, fast, lost=0.1),
    Kind("deaf now and then", "on_off", ON_OFF, deaf_now_and_then),
    Kind("timer", "on_off", ON_OFF, by_timer, follows=0.1),
    Kind("declared echo", "on_off", ON_OFF, echoing, has_declared_echo=True),
    Kind("dead behind an echo", "on_off", ON_OFF, dead_behind_an_echo, follows=0.0),
    Kind("fading", "level", LEVELS, fading),
    Kind("end first", "level", LEVELS, end_first),
    Kind("rounding", "level", LEVELS, rounding),
    Kind("blind", "position", POSITIONS, blind),
)


@pytest.fixture(scope="module")
def result() -> Result:
    """Simulate 12 parts of each kind."""
    found = Result()
    for kind in KINDS:
        for seed in range(12):
            SimulatedPart(kind, Random(f"{kind.name} {seed}"), found).run()  # noqa: S311
    print(found.text())  # noqa: T201 - the table is the result
    return found


def test_the_effects_of_commands_are_their_own(result: Result) -> None:
    assert result.share("command", OWN) >= 0.99


def test_no_person_is_told_to_be_the_device(result: Result) -> None:
    assert result.share("person", [Cause.DEVICE]) <= 0.005


def test_persons_are_named_or_unknown(result: Result) -> None:
    assert result.share("person", [Cause.PERSON]) >= 0.65
    assert result.share("person", [Cause.PERSON, Cause.UNKNOWN]) >= 0.95


def test_a_device_that_goes_back_is_no_person(result: Result) -> None:
    assert result.share("device", [Cause.PERSON]) <= 0.02


def test_commands_are_repeated_over_a_person_only_if_messages_were_lost(result: Result) -> None:
    assert result.overridden[False] == 0


def test_no_confirmed_command_of_an_honest_device_was_not_obeyed() -> None:
    found = Result()
    for seed in range(40):
        SimulatedPart(Kind("fast", "on_off", ON_OFF, fast, follows=0.0), Random(seed), found).run()  # noqa: S311
    assert {name for name, _ in found.outcomes} <= {"Confirmed"}
    assert found.outcomes["Confirmed", False] == 0


@given(st.sampled_from(KINDS), st.integers(0, 2**32))
@settings(max_examples=30)
def test_the_progress_of_commands_is_a_fold_of_the_facts(kind: Kind, seed: int) -> None:
    part = SimulatedPart(kind, Random(seed), Result())  # noqa: S311
    part.run(commands=5)
    again = rebuilt(part)
    assert again.commands
    assert [folded(one) for one in again.commands] == [folded(one) for one in part.timeline.commands]
    assert len(again.reports) == len(part.timeline.reports)


def folded(item: object) -> object:
    """Return the state of a command, without what it shares with others."""
    if isinstance(item, dict):
        return {name: folded(one) for name, one in item.items()}
    if isinstance(item, CommandProgress | Transmission | WantedValue):
        return folded(vars(item))
    if isinstance(item, Motion):
        return {name: getattr(item, name) for name in item.__slots__}
    return None if isinstance(item, DeviceProfile) else item


def rebuilt(part: SimulatedPart) -> PartTimeline:
    """Return a timeline that was fed with the facts of another one."""
    again = PartTimeline(DeviceProfile(), 10.0, 10.0)
    for at, feed in part.inputs:
        again.advance(at)
        feed(again)
    again.advance(part.inputs[-1][0] + 1000.0)
    return again
