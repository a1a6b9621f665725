"""Comparison of a reported value with the commanded one, by the columns of its capability. Pure."""

from __future__ import annotations

import math
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, CapabilityType
from homebot.devices.value import PlainValue

__all__ = ["fits", "is_intermediate", "is_other_end", "is_same"]

_ROUNDING: Final = 0.005
"""Of a number without a fineness: that of its text."""

_NUMBER: Final = 0.51
_DEFAULT: Final = CapabilityType("", "text", "")

_HUE: Final = 4.0  # degrees; 254 steps are 1.4 apart, and white has none
_SATURATION: Final = 4.5  # percent; by way of x and y with three digits magenta loses 4
_CIRCLE: Final = 360.0

_VIVID: Final = 70.0
"""Percent of saturation above which hardly any lamp shows all colours (Philips Hue, gamut types A to C)."""

_VIVID_HUE: Final = 30.0
_VIVID_SATURATION: Final = (-10.0, 35.0)
"""By how much the nearest colour that a lamp can show may differ from a vivid one: most are less saturated."""

_FEWEST_SPEEDS: Final = 2
_MOST_SPEEDS: Final = 10
_SPEED_ROUNDING: Final = 0.005
"""Of a speed: 33 % is the first of three, and 34 % the second."""

_HALF: Final = 0.5


def fits(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether a device that reports *seen* has done what *wanted* asked for, with its rounding."""
    match wanted, seen:
        case bool(), bool():
            return wanted is seen
        case str(), str():
            same = wanted.casefold() == seen.casefold()
            return same or seen.casefold() in _type(capability).accepts.get(wanted.casefold(), ())
        case tuple(), tuple():
            return _fits_numbers(capability, wanted, seen)
        case float(), float():
            if capability == "fan_speed" and _is_next_speed(wanted, seen):
                return True
            known = _type(capability)
            slack = known.relative_tolerance * wanted if known.relative_tolerance else known.tolerance
            return abs(wanted - seen) <= slack and not is_other_end(capability, wanted, seen)
        case _:
            return wanted is None and seen is None


def is_same(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether *seen* is *wanted* as closely as a device can tell, so that to command it would change nothing.

    This is stricter than :func:`fits`: half a degree more is a new setpoint, although a device may round to it. Of what
    has a motor, which stops a little off, and of the white of a lamp it is the same.
    """
    if not fits(capability, wanted, seen):
        return False
    if isinstance(wanted, float) and isinstance(seen, float):
        fineness = _type(capability).fineness
        return abs(wanted - seen) <= (_ROUNDING * abs(wanted) if fineness is None else fineness)
    if capability == "color" and isinstance(wanted, tuple) and isinstance(seen, tuple):
        return _is_same_color(wanted, seen)
    return True


def is_intermediate(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether *seen* shows that the device is on its way to *wanted*."""
    if isinstance(wanted, str) and isinstance(seen, str):
        return seen.casefold() in _type(capability).on_the_way.get(wanted.casefold(), ())
    return isinstance(seen, float) and _type(capability).moves


def _fits_numbers(capability: str, wanted: tuple[float, ...], seen: tuple[float, ...]) -> bool:
    if len(wanted) != len(seen):
        return False
    if capability != "color" or len(wanted) != 2:
        return all(abs(one - other) <= _NUMBER for one, other in zip(wanted, seen, strict=True))
    low, high = _VIVID_SATURATION
    is_nearest = _hue_between(wanted, seen) <= _VIVID_HUE and low <= wanted[1] - seen[1] <= high
    return (wanted[1] > _VIVID and is_nearest) or _is_same_color(wanted, seen)


def _is_same_color(wanted: tuple[float, ...], seen: tuple[float, ...]) -> bool:
    is_white = wanted[1] <= _SATURATION
    return abs(wanted[1] - seen[1]) <= _SATURATION and (is_white or _hue_between(wanted, seen) <= _HUE)


def _hue_between(wanted: tuple[float, ...], seen: tuple[float, ...]) -> float:
    around = abs(wanted[0] - seen[0]) % _CIRCLE
    return min(around, _CIRCLE - around)


def _is_next_speed(wanted: float, seen: float) -> bool:
    """Return whether *seen* is the speed that a fan with few of them takes for *wanted*: the next higher one."""
    if not 0 < wanted <= seen <= 100:
        return False
    for speeds in range(_FEWEST_SPEEDS, _MOST_SPEEDS + 1):
        speed = math.ceil(wanted * speeds / 100 - _SPEED_ROUNDING)
        if -_HALF <= speed * 100 / speeds - seen < 1:  # of 66.7 %, some report 66 and others 67
            return True
    return False


def is_other_end(capability: str, wanted: float, seen: float) -> bool:
    """Return whether one of two close levels is 0, which is off, or closed."""
    return _type(capability).zero_is_off and (wanted == 0) != (seen == 0)


def _type(capability: str) -> CapabilityType:
    return CAPABILITIES.get(capability, _DEFAULT)
