"""Quantities with their units and bounds, for the whole project."""

import math
from datetime import timedelta
from string import ascii_lowercase
from typing import Annotated, Final

from pydantic import BeforeValidator, Field

from homebot.errors import UsageError


def _from_text(value: object) -> object:
    """Return a text as seconds, and anything else unchanged."""
    if not isinstance(value, str):
        return value
    try:
        seconds = parse_duration(value)
    except UsageError as exc:
        raise ValueError(str(exc)) from exc
    return int(seconds) if seconds.is_integer() else seconds


MAX_WAIT: Final = 100 * 366 * 86_400.0
"""100 years, in seconds; a look back may be longer, as it means all that is there."""

DURATION: Final = BeforeValidator(_from_text)
"""Validator that also accepts texts such as ``"7d"`` for seconds in a configuration."""

Seconds = Annotated[float, DURATION, Field(gt=0, allow_inf_nan=False, description="seconds")]
Celsius = Annotated[float, Field(ge=-273.15, allow_inf_nan=False, description="degrees Celsius")]
Bytes = Annotated[int, Field(gt=0, description="bytes")]
Port = Annotated[int, Field(ge=0, le=65_535, description="TCP port; 0 is any free one")]


def parse_duration(text: str | float | timedelta, key: str = "", *, most: float = math.inf) -> float:
    """Return a length of time in seconds.

    Args:
        text: A number and a unit, or several with the larger unit first: ``90s``, ``1h30m``, ``1.5d``, ``500ms``,
            ``2 hours``, ``half an hour``. A plain number is seconds.
        key: The name of the setting or argument, for the error.
        most: :data:`MAX_WAIT` for what is waited for.

    Raises:
        UsageError: It cannot be parsed, is negative or infinite, or is more than *most*.
    """
    where = f"{key}: " if key else ""
    if isinstance(text, str):
        seconds = _read_seconds(text)
        if seconds is None:
            raise UsageError(f"{where}{text!r} is not a duration; write it like 90s, 8h or 1h30m (d, h, m, s, ms)")
    else:
        seconds = text.total_seconds() if isinstance(text, timedelta) else text
        if type(seconds) not in (int, float) or not 0 <= seconds < math.inf:
            raise UsageError(f"{where}{text} is not a duration: it must be a finite number of seconds, 0 or more")
    if seconds > most or seconds == math.inf:
        raise UsageError(f"{where}{text!r} is more than 100 years, the most that is possible")
    return float(seconds)


_UNITS: Final = {
    **dict.fromkeys(("d", "day", "days"), 86_400.0),
    **dict.fromkeys(("h", "hour", "hours"), 3_600.0),
    **dict.fromkeys(("m", "min", "mins", "minute", "minutes"), 60.0),
    **dict.fromkeys(("s", "sec", "secs", "second", "seconds"), 1.0),
    "ms": 0.001,
}
_NUMBER_WORDS: Final = {"half an ": 0.5, "half a ": 0.5, "an ": 1.0, "a ": 1.0, "one ": 1.0}


def _read_seconds(text: str) -> float | None:
    """Return the seconds of one or more quantities, the largest unit first; None for anything else."""
    rest, seconds, larger = text.strip().lower(), 0.0, math.inf
    while rest or larger == math.inf:
        word = next((word for word in _NUMBER_WORDS if rest.startswith(word)), "")
        digits = rest[: len(rest) - len(rest.lstrip("0123456789."))]
        if not word and not (digits.replace(".", "", 1).isdecimal() and digits[0] != "." != digits[-1]):
            return None
        rest = rest[len(word or digits) :].lstrip()
        name = rest[: len(rest) - len(rest.lstrip(ascii_lowercase))]
        unit = _UNITS.get(name, math.inf)
        if unit >= larger:
            return None
        seconds += (_NUMBER_WORDS[word] if word else float(digits)) * unit
        rest, larger = rest[len(name) :].lstrip().removeprefix("and "), unit
    return seconds
