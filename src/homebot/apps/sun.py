"""Times of the sun at a location. On a day without sunrise or sunset, as beyond the polar circles, there is none."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import UTC, date, datetime, timedelta, tzinfo
from typing import Final, final

import astral
from astral import sun

from homebot.errors import UsageError
from homebot.support.similar import did_you_mean

_DAY: Final = timedelta(days=1)
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


def sun_elevation(now: float, latitude: float | None, longitude: float | None) -> float:
    """Return the degrees of the sun above the horizon *now*, in seconds since the Unix epoch, without refraction.

    Raises:
        UsageError: The location is unknown.
    """
    place = _observer("the elevation of the sun", latitude, longitude)
    return sun.elevation(place, datetime.fromtimestamp(now, UTC), with_refraction=False)


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


def elevation_time(
    degrees: float, latitude: float | None, longitude: float | None, *, is_rising: bool
) -> ElevationTime:
    """Return the time at which the rising or setting sun passes so many *degrees*.

    Raises:
        UsageError: The location is unknown.
    """
    return ElevationTime(_observer("the elevation of the sun", latitude, longitude), degrees, is_rising)


def _observer(asked: str, latitude: float | None, longitude: float | None) -> astral.Observer:
    if latitude is None or longitude is None:
        raise UsageError(f"{asked} needs the place of the home: set latitude and longitude in the table [home]")
    return astral.Observer(latitude, longitude)
