"""The sun and the weather, simple enough to read."""

from __future__ import annotations

import math

__all__ = ["DAY", "daylight", "weather"]

DAY = 86_400.0
NOON_LUX = 100_000.0
"""A clear sky with the sun overhead."""


def daylight(now: float, first_day: int, latitude: float) -> float:
    """Return the lux outside under a clear sky: in proportion to the sine of the sun's height, 0 when it is down.

    Args:
        now: Seconds since the midnight that begins the first day; local solar time.
        first_day: Day of the year of that day, 1 to 366.
        latitude: Degrees north.
    """
    day = first_day + now // DAY
    declination = math.radians(-23.44) * math.cos(math.tau * (day + 10) / 365.25)
    turned = math.tau * (now % DAY / DAY - 0.5)
    north = math.radians(latitude)
    height = math.sin(north) * math.sin(declination) + math.cos(north) * math.cos(declination) * math.cos(turned)
    return NOON_LUX * max(0.0, height)


def weather(now: float, first_day: int) -> float:
    """Return the degrees Celsius outside: warmest in late July and at three in the afternoon; arguments as above."""
    season = math.cos(math.tau * (first_day + now / DAY - 205) / 365.25)
    hour = math.cos(math.tau * (now % DAY / DAY - 15 / 24))
    return 10.0 + 10.0 * season + 4.0 * hour
