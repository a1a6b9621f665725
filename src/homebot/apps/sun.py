"""Times of the sun at a location. On a day without sunrise or sunset, as beyond the polar circles, there is none."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, date, datetime, time, timedelta, tzinfo
from typing import Final, final

import astral
from astral import sun

from homebot.errors import UsageError
from homebot.support.names import did_you_mean
from homebot.words.triggers import SunAngle

_DAY: Final = timedelta(days=1)
_QUARTER: Final = timedelta(minutes=15)
_QUARTERS: Final = 96
_TWO_DAYS: Final = 46 * 3600.0  # about
_HORIZON: Final = -0.833  # degrees: the upper limb, with refraction, as at sunrise and sunset

_EVENTS: Final[Mapping[str, Callable[..., datetime]]] = {
    "dawn": sun.dawn,
    "sunrise": sun.sunrise,
    "noon": sun.noon,
    "sunset": sun.sunset,
    "dusk": sun.dusk,
}


@final
@dataclass(frozen=True, slots=True)
class SunTime:
    """A time with an offset in seconds from an event of the sun; it belongs to the local date of the event."""

    event: str
    place: astral.Observer
    offset: float

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if there is no such event."""
        moment = self._find(day, zone)
        if moment is None and (before := self._find(day - _DAY, zone)) and (after := self._find(day + _DAY, zone)):
            # astral finds none on one day of the year if the event moves over midnight UTC, as sunrise in India does.
            # In the far north, an event that moves over local midnight really leaves out a day.
            moment = (before + after) / 2 if after - before > _TWO_DAYS else None
        return None if moment is None else moment + self.offset

    def _find(self, day: date, zone: tzinfo) -> float | None:
        try:
            return _EVENTS[self.event](self.place, date=day, tzinfo=zone).timestamp()
        except ValueError:
            return None


def sun_time(event: str, latitude: float | None, longitude: float | None, offset: float) -> SunTime:
    """Return the time *offset* seconds after *event*.

    Raises:
        UsageError: There is no such event, or the location is unknown.
    """
    if type(event) is not str or event not in _EVENTS:
        hint = did_you_mean(event, _EVENTS, f"events are {', '.join(_EVENTS)}; for a time of day use daily()")
        raise UsageError(f"there is no event {event!r} of the sun; {hint}")
    return SunTime(event, _observer(event, latitude, longitude), offset)


def is_sun_up(now: float, latitude: float | None, longitude: float | None) -> bool:
    """Return whether the sun is up *now*, in seconds since the Unix epoch.

    Raises:
        UsageError: The location is unknown.
    """
    place = _observer("sun_is_up", latitude, longitude)
    return sun.elevation(place, datetime.fromtimestamp(now, UTC), with_refraction=False) > _HORIZON


def sun_angle(now: float, latitude: float | None, longitude: float | None, *, is_azimuth: bool = False) -> float:
    """Return the degrees of the sun above the horizon, or from the north, *now*, in seconds since the Unix epoch.

    Refraction is left out.

    Raises:
        UsageError: The location is unknown.
    """
    place, at = _observer("the angle of the sun", latitude, longitude), datetime.fromtimestamp(now, UTC)
    return sun.azimuth(place, at) if is_azimuth else sun.elevation(place, at, with_refraction=False)


@final
@dataclass(frozen=True, slots=True)
class ElevationTime:
    """The time at which the rising or setting sun passes an elevation, in degrees."""

    place: astral.Observer
    degrees: float
    is_rising: bool

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if there is none."""
        way = astral.SunDirection.RISING if self.is_rising else astral.SunDirection.SETTING
        try:
            noon = sun.noon(self.place, date=day, tzinfo=zone)
            moment = sun.time_at_elevation(
                self.place, self.degrees, date=day, direction=way, tzinfo=zone, with_refraction=False
            )
        except ValueError:
            return None
        is_of_day = (moment <= noon) is self.is_rising
        return moment.timestamp() if is_of_day else None


@final
@dataclass(frozen=True, slots=True)
class AzimuthTime:
    """The time at which the sun comes above or below an azimuth, in degrees."""

    place: astral.Observer
    degrees: float
    is_above: bool

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if there is none."""
        begin = datetime.combine(day, time(), zone)
        steps = [begin + number * _QUARTER for number in range(_QUARTERS + 1)]
        sides = [self._is_reached(at) for at in steps]
        reached = next((place for place in range(1, len(steps)) if sides[place] and not sides[place - 1]), 0)
        if not reached:
            return None
        before, after = steps[reached - 1].timestamp(), steps[reached].timestamp()
        while after - before > 1.0:
            middle = (before + after) / 2
            before, after = (before, middle) if self._is_reached(_at(middle)) else (middle, after)
        return after if _at(after).astimezone(zone).date() == day else None

    def _is_reached(self, at: datetime) -> bool:
        return (sun.azimuth(self.place, at) > self.degrees) is self.is_above


def _at(moment: float) -> datetime:
    return datetime.fromtimestamp(moment, UTC)


def angle_time(angle: SunAngle, latitude: float | None, longitude: float | None) -> ElevationTime | AzimuthTime:
    """Return the time at which the sun passes *angle*.

    Raises:
        UsageError: The location is unknown.
    """
    place = _observer("the angle of the sun", latitude, longitude)
    return (AzimuthTime if angle.is_azimuth else ElevationTime)(place, angle.degrees, angle.is_above)


def _observer(asked: str, latitude: float | None, longitude: float | None) -> astral.Observer:
    if latitude is None or longitude is None:
        raise UsageError(f"{asked} needs the place of the home: set latitude and longitude in the table [home]")
    return astral.Observer(latitude, longitude)
