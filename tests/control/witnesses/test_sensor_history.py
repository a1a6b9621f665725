"""What a sensor told lately, by time and by number."""

from __future__ import annotations

from homebot.control.witnesses.sensor_history import SensorHistory


def history(*readings: tuple[float, float]) -> SensorHistory:
    """A history of readings: the time and the value of each."""
    found = SensorHistory()
    for at, value in readings:
        found.note(value, at)
    return found


def test_a_change_is_counted_from_the_reading_at_the_mark() -> None:
    """Also where everything happens at one time; the time is that at which it had come half way."""
    lux = history((0.0, 10.0), (5.0, 60.0), (6.0, 160.0), (9.0, 5.0))
    assert lux.change(1, 8.0, rises=True) == (150.0, 6.0)
    assert lux.change(1, 9.0, rises=False) == (5.0, 9.0)
    assert lux.change(3, 8.0, rises=True) == (0.0, 8.0)


def test_the_same_reading_again_is_none() -> None:
    assert history((0.0, 10.0), (1.0, 10.0)).count == 1


def test_what_is_forgotten_tells_nothing() -> None:
    lux = history(*((float(at), float(at)) for at in range(600)))
    assert lux.begins == 88.0
    assert lux.swing(50.0, 600) is None
    assert lux.change(10, 700.0, rises=True) is None


def test_the_swing_is_that_before_the_mark() -> None:
    lux = history((0.0, 10.0), (5.0, 14.0), (8.0, 12.0), (9.0, 500.0))
    assert lux.swing(1.0, 3) == 4.0
    assert lux.swing(6.0, 3) == 2.0
