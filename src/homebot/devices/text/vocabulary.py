"""Vocabulary of values in plain text; see :mod:`homebot.devices.text.encode`. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Final

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability

__all__ = [
    "BOOL_WORDS",
    "FRACTION_CAPABILITIES",
    "OPENING_WORDS",
    "PRIORITY",
    "SPEED_WORDS",
    "bounds_of",
    "percent",
    "says_unknown",
]

FRACTION_CAPABILITIES: Final = frozenset({"level", "position", "tilt", "fan_speed", "volume"})
"""Percentages that are spoken as 0 to 1."""

SPEED_WORDS: Final = frozenset({"level", "fan_speed"})
"""What is 0 only where it is off."""

_UNKNOWN: Final = frozenset({"none", "null", "unknown", "unavailable"})
_LONGEST_UNKNOWN: Final = 40

OPENING_WORDS: Final = ("movement", "valve")

PRIORITY: Final = ("lock", "on_off", "occupancy", "contact", "vacuum", "mower", "alarm", "local_temperature")
"""What a message is about when it tells several things; openings, which come next, have a rule of their own."""

BOOL_WORDS: Final[Mapping[str, tuple[str, str]]] = {"occupancy": ("clear", "motion"), "contact": ("closed", "open")}
"""Words for no and yes; of any other flag ``off`` and ``on``."""


def bounds_of(capability: Capability) -> tuple[float, float]:
    """Return the smallest and the largest value of *capability*; infinite where none is known."""
    known = CAPABILITIES.get(capability.name)
    bounds = capability.bounds or (known.bounds if known else ())
    return (bounds[0], bounds[-1]) if bounds else (-math.inf, math.inf)


def says_unknown(text: str | bytes) -> bool:
    """Tell whether *text*, said in the place of a number, means that there is none: NaN and its like, or a word."""
    if len(text) > _LONGEST_UNKNOWN:
        return False
    try:
        return not math.isfinite(float(text))
    except ValueError:
        word = text.decode(errors="replace") if isinstance(text, bytes) else text
        return word.strip().lower() in _UNKNOWN


def percent(share: float) -> float:
    """Return *share* in percent, as short as it was spelt: 0.07 is 7 %, not 7.000000000000001."""
    return round(share * 100, 9)
