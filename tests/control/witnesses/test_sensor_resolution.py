"""How finely a sensor reports, by the changes that it reported."""

from __future__ import annotations

from homebot.control.witnesses.sensor_history import SensorHistory
from homebot.control.witnesses.sensor_resolution import SensorResolution


def resolution(*readings: tuple[float, float]) -> SensorResolution:
    """That of a sensor with these readings: the time and the value of each."""
    found = SensorHistory()
    for at, value in readings:
        found.note(value, at)
    return found.resolution


def test_three_small_steps_show_how_finely_it_reports() -> None:
    """From values as high, and within three days."""
    lux = resolution((0.0, 100.0), (1.0, 110.0), (2.0, 100.0), (3.0, 110.0), (4.0, 0.0), (5.0, 150.0))
    assert lux.is_finer_than(10.0, 100.0, 6.0)
    assert not lux.is_finer_than(9.0, 100.0, 6.0)
    assert not lux.is_finer_than(10.0, 105.0, 6.0)
    assert not lux.is_finer_than(10.0, 100.0, 300_000.0)


def test_great_steps_do_not_push_small_ones_out() -> None:
    steps = [(0.0, 100.0), (1.0, 110.0), (2.0, 100.0), (3.0, 110.0), (4.0, 100.0)]
    steps += [(5.0 + turn, 400.0 if turn % 2 == 0 else 100.0) for turn in range(100)]
    assert resolution(*steps).is_finer_than(10.0, 100.0, 200.0)


def test_a_meter_of_one_load_knows_two_values() -> None:
    one = [(float(at), 9.0 if at % 2 else 0.0) for at in range(20)]
    assert resolution(*one).has_two_levels(9.0)
    assert not resolution(*one).has_two_levels(4.0)
    assert not resolution(*one, (21.0, 4.0)).has_two_levels(9.0)


def test_what_an_earlier_run_knew_is_taken_over_beside_what_is_known_now() -> None:
    earlier = resolution((0.0, 100.0), (1.0, 110.0), (2.0, 100.0))
    now = resolution((50.0, 100.0), (51.0, 110.0))
    assert not now.is_finer_than(10.0, 100.0, 60.0)
    now.restore(earlier.steps, earlier.levels)
    assert now.is_finer_than(10.0, 100.0, 60.0)
    assert now.levels == (100.0, 110.0, 100.0, 100.0, 110.0)


def test_an_old_step_takes_no_place_of_a_new_one() -> None:
    earlier = resolution(*((float(at), 100.0 + 10.0 * (at % 2)) for at in range(9)))
    now = resolution(*((300.0 + at, 100.0 + 10.0 * (at % 2)) for at in range(9)))
    known = now.steps
    now.restore(earlier.steps, earlier.levels)
    assert now.steps == known


def test_a_load_that_an_earlier_run_saw_is_still_the_only_one() -> None:
    now = resolution((50.0, 0.0))
    now.restore((), [9.0, 0.0] * 8)
    assert now.has_two_levels(9.0)
    now.restore((), [])
    assert len(now.levels) == 16
