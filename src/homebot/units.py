"""Quantities with their units and bounds, for the whole project."""

import math
import re
from datetime import timedelta
from typing import Annotated, Final

from pydantic import BeforeValidator, Field

from homebot.errors import UsageError

__all__ = ["DURATION", "LONGEST_WAIT", "Bytes", "Celsius", "Port", "Seconds", "parse_duration"]


def _from_text(value: object) -> object:
    """Return a text as seconds, and anything else unchanged."""
    if not isinstance(value, str):
        return value
    try:
        seconds = parse_duration(value)
    except UsageError as exc:
        raise ValueError(str(exc)) from exc
    return int(seconds) if seconds.is_integer() else seconds


LONGEST_WAIT: Final = 100 * 366 * 86_400.0
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
        text: A number and a unit, or several with the larger unit first: ``90s``, ``1h30m``, ``1.5d``, ``500ms``.
            Units are d, h, m, s and ms. A plain number is seconds.
        key: The name of the setting or argument, for the error.
        most: :data:`LONGEST_WAIT` for what is waited for.

    Raises:
        UsageError: It cannot be parsed, is negative or infinite, or is more than *most*.
    """
    where = f"{key}: " if key else ""
    if isinstance(text, str):
        parts = _DURATION.fullmatch(text.strip())
        if parts is None or not any(parts.groups()):
            raise UsageError(f"{where}{text!r} is not a duration; write it like 90s, 8h or 1h30m (d, h, m, s, ms)")
        seconds = sum(float(part) * unit for part, unit in zip(parts.groups("0"), _UNITS.values(), strict=True))
    else:
        seconds = text.total_seconds() if isinstance(text, timedelta) else text
        if type(seconds) not in (int, float) or not 0 <= seconds < math.inf:
            raise UsageError(f"{where}{text} is not a duration: it must be a finite number of seconds, 0 or more")
    if seconds > most or seconds == math.inf:
        raise UsageError(f"{where}{text!r} is more than 100 years, the most that is possible")
    return float(seconds)


_UNITS: Final = {"d": 86_400.0, "h": 3_600.0, "m": 60.0, "s": 1.0, "ms": 0.001}
_DURATION: Final = re.compile("".join(rf"(?:(\d+(?:\.\d+)?)\s*{unit}(?![a-z])\s*)?" for unit in _UNITS), re.ASCII)
