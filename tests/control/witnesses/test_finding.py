"""One sensor's judgement of one command, by its readings alone."""

from __future__ import annotations

import pytest

from homebot.control.witnesses.effect import Effect
from homebot.control.witnesses.finding import Finding, WatchTimes, can_tell, finding_of, observe
from homebot.control.witnesses.sensor_history import SensorHistory
from homebot.control.witnesses.witness_record import Expected, Observation, WitnessRecord

UP, DOWN = Effect(rises=True, size=100.0), Effect(rises=False, size=100.0)
EXPECTED = Expected(least=100.0, most=100.0, slowest=1.0, within=5.0)
TIMES = WatchTimes(quiet_since=10.0, mark=1, began=100.0, reported=100.5, until=106.0)


def history(*readings: tuple[float, float]) -> SensorHistory:
    found = SensorHistory()
    for at, value in readings:
        found.note(value, at)
    return found


def known(before: float) -> WitnessRecord:
    """The record of a sensor that saw ten effects, from *before* on."""
    found = WitnessRecord()
    for _ in range(5):
        found.note(Observation(UP, before, 100.0, 1.0, 0.0))
        found.note(Observation(DOWN, before + 100.0, 100.0, 1.0, 0.0))
    return found


@pytest.mark.parametrize(
    ("after", "finding"),
    [
        (100.0, Finding.SAW),
        (50.0, Finding.SAW),
        (49.0, Finding.UNCLEAR),
        (201.0, Finding.UNCLEAR),
        (6.0, Finding.NOTHING),
        (7.0, Finding.UNCLEAR),
        (-7.0, Finding.UNCLEAR),
    ],
)
def test_a_change_of_about_the_usual_size_is_the_effect_and_a_tiny_one_is_none(after: float, finding: Finding) -> None:
    assert finding_of(history((0.0, 0.0), (101.0, after)), EXPECTED, UP, TIMES) is finding


def test_a_sensor_that_moves_by_itself_tells_nothing() -> None:
    lux = history((0.0, 0.0), (50.0, 30.0), (60.0, 0.0), (101.0, 100.0))
    times = WatchTimes(10.0, 3, 100.0, 100.5, 106.0)
    assert finding_of(lux, EXPECTED, UP, times) is Finding.UNCLEAR


def test_a_change_is_observed_with_its_delay_after_the_report() -> None:
    assert observe(history((0.0, 3.0), (101.0, 103.0)), UP, TIMES) == Observation(UP, 3.0, 100.0, 0.5, 0.0)
    assert observe(history((0.0, 3.0)), UP, TIMES) == Observation(UP, 3.0, 0.0, 5.5, 0.0)
    assert observe(history((50.0, 3.0)), UP, TIMES) is None  # how it was before is not known


@pytest.mark.parametrize(
    ("effect", "before", "tells"),
    [(UP, 0.0, True), (UP, 6.0, True), (UP, 7.0, False), (DOWN, 100.0, False)],
)
def test_a_coarse_light_sensor_tells_of_a_missing_rise_from_darkness_alone(
    effect: Effect, before: float, *, tells: bool
) -> None:
    assert can_tell(known(7.0), history((0.0, before)), EXPECTED, effect, TIMES, "illuminance") is tells


def test_a_sensor_in_much_other_light_does_not_tell() -> None:
    fine = [(float(at), 60.0 + at % 2) for at in range(9)]
    times = WatchTimes(10.0, 9, 100.0, 100.5, 106.0)
    assert not can_tell(known(60.0), history(*fine), EXPECTED, UP, times, "illuminance")
    low = [(float(at), 20.0 + at % 2) for at in range(9)]
    assert can_tell(known(20.0), history(*low), EXPECTED, UP, times, "illuminance")


def test_a_contact_needs_no_fine_steps() -> None:
    contact = Expected(1.0, 1.0, 1.0, 5.0)
    record = WitnessRecord()
    for _ in range(5):
        record.note(Observation(UP, 0.0, 1.0, 1.0, 0.0))
        record.note(Observation(DOWN, 1.0, 1.0, 1.0, 0.0))
    assert can_tell(record, history((0.0, 1.0)), contact, DOWN, TIMES, "contact")
