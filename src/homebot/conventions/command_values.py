"""Checks of commanded values, and writers of commands with them. Pure."""

import math
from collections.abc import Callable, Iterable, Mapping
from datetime import date, datetime, time
from typing import TypeAlias

from homebot.conventions.description import Publications
from homebot.conventions.payload import shown
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

Writer: TypeAlias = Callable[[PlainValue, float], Publications]
"""Writes a value with a transition in seconds. Like all checks here, raises RefusedError with the accepted values."""

_MAX_NAMED = 20
_MAX_MOMENT = 64
_MOMENTS: Mapping[str, Callable[[str], date | time | datetime]] = {
    "date": date.fromisoformat,
    "datetime": datetime.fromisoformat,
    "time": time.fromisoformat,
}


def require_bool(capability: str, value: PlainValue) -> bool:
    """Return *value*, which must be true or false."""
    if isinstance(value, bool):
        return value
    raise RefusedError(f"{capability} {shown(value)}", "it takes true or false")


def require_true(capability: str, value: PlainValue) -> None:
    """Check that *value* is true, the only one of an action without state."""
    if value is not True:
        raise RefusedError(f"{capability} {shown(value)}", "it takes only true")


def require_number(capability: str, value: PlainValue, least: float, most: float, unit: str = "") -> float:
    """Return *value*, which must be a number within the bounds."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and least <= value <= most:
        return float(value)
    is_bounded = math.isfinite(most - least)
    takes = f"it takes a number from {least:g} to {most:g} {unit}".rstrip() if is_bounded else "it takes a number"
    raise RefusedError(f"{capability} {shown(value)}", takes)


def require_color(value: PlainValue) -> tuple[float, float]:
    """Return the hue, 0 to 360, and the saturation, 0 to 100, of *value*."""
    match value:
        case (int() | float() as hue, int() | float() as saturation) if 0 <= hue <= 360 and 0 <= saturation <= 100:
            return float(hue), float(saturation)
    raise RefusedError(f"color {shown(value)}", "it takes numbers from 0 to 360, 0 to 100")


def moment_text(kind: str, value: PlainValue) -> str | None:
    """Return *value* in the usual form of ISO 8601 if it is a *kind*: a ``date``, a ``time`` or a ``datetime``."""
    try:
        return _MOMENTS[kind](value.strip()[:_MAX_MOMENT] if isinstance(value, str) else "").isoformat()
    except ValueError:
        return None


def require_moment(kind: str, value: PlainValue, *, zoned: bool = True) -> str:
    """Return :func:`moment_text` of *value*, which must be one; only a *zoned* datetime has a time zone."""
    moment = moment_text(kind, value)
    if moment is None:
        raise RefusedError(f"text {shown(value)}", f"it takes a {kind} in ISO 8601 format")
    if kind == "datetime" and (datetime.fromisoformat(moment).tzinfo is not None) is not zoned:
        problem = "it takes a datetime with a time zone" if zoned else "it takes a datetime without a time zone"
        raise RefusedError(f"text {shown(value)}", problem)
    return moment


def require_transition(seconds: float, most: float = math.inf) -> float:
    """Return *seconds*, which must be 0 to *most*."""
    if math.isfinite(seconds) and 0 <= seconds <= most:
        return seconds
    takes = "0 or more seconds" if math.isinf(most) else f"0 to {most:g} s"
    raise RefusedError(f"a transition of {seconds:g} s", f"it takes {takes}")


def require_option(capability: str, value: PlainValue, options: Iterable[str]) -> str:
    """Return *value*, which must be one of the *options*."""
    known = tuple(options)
    if isinstance(value, str) and value in known:
        return value
    named = ", ".join(known[:_MAX_NAMED]) + (", …" if len(known) > _MAX_NAMED else "")
    raise RefusedError(f"{capability} {shown(value)}", f"it takes {named}" if known else "it takes none")


def bool_writer(capability: str, publish: Callable[[bool], Publications]) -> Writer:
    """Return a writer of true and false without transition."""
    return lambda value, _transition: publish(require_bool(capability, value))


def number_writer(
    capability: str, bounds: tuple[float, ...], unit: str, publish: Callable[[float], Publications]
) -> Writer:
    """Return a writer of numbers within the *bounds*, without transition."""
    least, most = bounds
    return lambda value, _transition: publish(require_number(capability, value, least, most, unit))


def percent_writer(capability: str, publish: Callable[[float], Publications]) -> Writer:
    """Return a writer of percent, without transition."""
    return number_writer(capability, (0.0, 100.0), "%", publish)


def speed_of(percent: float, speeds: float) -> int:
    """Return the number of a speed, of so many *speeds*: the next higher one, as in Home Assistant."""
    return math.ceil(round(percent * speeds / 100, 4))


def option_writer(capability: str, options: Iterable[str], publish: Callable[[str], Publications]) -> Writer:
    """Return a writer of one of the *options* without transition."""
    return lambda value, _transition: publish(require_option(capability, value, options))


def push_writer(capability: str, publish: Callable[[], Publications]) -> Writer:
    """Return a writer of true alone, for an action without state."""

    def write(value: PlainValue, _transition: float) -> Publications:
        require_true(capability, value)
        return publish()

    return write
