"""When a sensor is trusted, and for what."""

from __future__ import annotations

from dataclasses import replace

from homebot.control.witnesses.effect import Effect
from homebot.control.witnesses.witness_record import ENOUGH, Expected, Observation, WitnessRecord

UP, DOWN = Effect(rises=True, size=100.0), Effect(rises=False, size=100.0)


def record(*observations: Observation) -> WitnessRecord:
    """A record of observations."""
    found = WitnessRecord()
    for one in observations:
        found.note(one)
    return found


def seen(effect: Effect, change: float = 100.0, before: float = 0.0, delay: float = 1.0) -> Observation:
    """An observation without any movement before it."""
    return Observation(effect, before, change, delay, 0.0)


def test_it_is_trusted_after_enough_in_both_directions() -> None:
    ups, downs = [seen(UP)] * ENOUGH, [seen(DOWN, before=100.0)] * ENOUGH
    assert record(*ups, *downs).expected(rises=True) == Expected(100.0, 100.0, 1.0, 5.0)
    assert record(*ups, *downs[1:]).expected(rises=True) is None
    assert record(*ups).expected(rises=True) is None


def test_a_sensor_that_mostly_saw_nothing_is_not_trusted() -> None:
    nothing = [seen(UP, change=0.0)] * 6
    assert record(*[seen(UP)] * 5, *nothing, *[seen(DOWN)] * 5).expected(rises=True) is None


def test_directions_that_differ_much_are_not_one_effect() -> None:
    """As where the sun rises while lamps are turned on."""
    assert record(*[seen(UP, 100.0)] * 5, *[seen(DOWN, 40.0)] * 5).expected(rises=True) is None


def test_a_sensor_that_moves_by_itself_as_much_is_not_trusted() -> None:
    noisy = Observation(UP, 0.0, 100.0, 1.0, swing=60.0)
    assert record(*[noisy] * 5, *[seen(DOWN)] * 5).expected(rises=True) is None


def test_it_vouches_where_it_saw_as_much_under_as_hard_conditions() -> None:
    """A brighter room and a smaller change are harder, another colour is unknown."""
    known = record(*[seen(UP, before=20.0)] * 5, *[seen(DOWN)] * 5)
    assert known.has_seen_as_hard(UP, 20.0)
    assert known.has_seen_as_hard(UP, 5.0)
    assert not known.has_seen_as_hard(UP, 80.0)
    assert not known.has_seen_as_hard(Effect(rises=True, size=60.0), 20.0)
    assert not known.has_seen_as_hard(Effect(rises=True, size=100.0, looks=" 8/4"), 20.0)


def test_one_that_it_missed_where_that_was_as_easy_ends_the_trust() -> None:
    known = [*[seen(UP, before=20.0)] * 5, *[seen(DOWN)] * 5]
    assert not record(*known, seen(UP, change=0.0, before=10.0)).has_seen_as_hard(UP, 20.0)
    assert record(*known, seen(UP, change=0.0, before=300.0)).has_seen_as_hard(UP, 20.0)


def test_what_it_missed_while_it_moved_by_itself_does_not_count() -> None:
    known = [*[seen(UP, before=20.0)] * 5, *[seen(DOWN)] * 5]
    assert record(*known, Observation(UP, 10.0, 0.0, 1.0, swing=60.0)).has_seen_as_hard(UP, 20.0)


def test_a_sensor_that_reports_changes_alone_is_unfailing_after_sixteen_in_a_row() -> None:
    ups, downs = [replace(seen(one), fell_silent=True) for one in (UP, DOWN)]
    known = record(*[ups, downs] * 7, ups)
    assert not known.is_unfailing
    known.note(downs)
    assert known.is_unfailing
    known.note_silence()
    assert not known.is_unfailing


def test_a_sensor_that_repeats_its_readings_is_never_unfailing() -> None:
    """Its silence tells that it is out of order."""
    assert not record(*[seen(UP), seen(DOWN)] * 16).is_unfailing


def test_old_observations_are_forgotten() -> None:
    """So that a new bulb is known after a while."""
    known = record(*[seen(UP, 100.0)] * 20, *[seen(DOWN, 100.0)] * 20, *[seen(UP, 30.0)] * 16, *[seen(DOWN, 30.0)] * 16)
    expected = known.expected(rises=True)
    assert expected is not None
    assert (expected.least, expected.most) == (30.0, 30.0)
