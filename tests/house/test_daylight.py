"""Sun and weather follow the day and the year."""

from __future__ import annotations

import pytest

from homebot.house.rooms import DAY, daylight, weather

NOON = DAY / 2


def test_the_sun_is_highest_at_noon_and_down_at_midnight() -> None:
    """In the middle of Europe."""
    assert daylight(0.0, 80, 48.0) == 0.0
    assert daylight(NOON, 80, 48.0) == pytest.approx(67_000, rel=0.02)
    assert daylight(NOON - 3600, 80, 48.0) == pytest.approx(daylight(NOON + 3600, 80, 48.0))


@pytest.mark.parametrize(("latitude", "brighter", "darker"), [(48.0, 172, 355), (-48.0, 355, 172)])
def test_summer_is_brighter_on_either_half_of_the_globe(latitude: float, brighter: int, darker: int) -> None:
    """At opposite ends of the year."""
    assert daylight(NOON, brighter, latitude) > 2 * daylight(NOON, darker, latitude)


def test_the_sun_does_not_set_in_the_north_in_summer() -> None:
    """Nor rise in winter."""
    assert daylight(0.0, 172, 75.0) > 0.0
    assert daylight(NOON, 355, 75.0) == 0.0


def test_days_follow_the_first() -> None:
    """Ninety days after the winter solstice it is spring."""
    assert daylight(90 * DAY + NOON, 355, 48.0) == pytest.approx(daylight(NOON, 80, 48.0), rel=0.01)


def test_afternoons_and_summers_are_warm() -> None:
    """Nights and winters are not."""
    assert weather(15 * 3600.0, 205) == pytest.approx(24.0, abs=0.1)
    assert weather(3 * 3600.0, 22) == pytest.approx(-4.0, abs=0.1)
