"""Comparison of a reported value with the one that was commanded. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["fits", "is_intermediate", "is_other_end", "is_same"]

_ABSOLUTE: Final[Mapping[str, float]] = MappingProxyType(
    {"level": 1.5, "position": 3.0, "tilt": 3.0, "fan_speed": 5.0, "volume": 1.5, "humidity_setpoint": 1.0}
)
"""By how many units a device may round: most count a percentage in 100 or 254 steps, motors stop a little off."""

_RELATIVE: Final[Mapping[str, float]] = MappingProxyType({"color_temperature": 0.02})
"""Whole mireds are up to 1.3 % of a cold white apart (Matter 1.6 application clusters, section 3.2.7)."""

_NUMBER: Final = 0.51
"""Of numbers without a rule, such as temperatures: most devices take halves."""

_STEPS: Final[Mapping[str, float]] = MappingProxyType(
    {"level": 0.8, "volume": 0.8, "heating_setpoint": 0.29, "cooling_setpoint": 0.29}
    | {"humidity_setpoint": 0.51, "fan_speed": 5.0}
)
"""By how much a device with small steps rounds: a percentage by way of 255 and 99, or to half a degree, or 1 °F."""

_ROUNDING: Final = 0.005
"""Of the number of a setting, whose steps are not known: that of its text."""

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

_SAME: Final[Mapping[tuple[str, str], frozenset[str]]] = MappingProxyType(
    {
        ("movement", "stopped"): frozenset({"open", "closed"}),
        ("valve", "stopped"): frozenset({"open", "closed"}),
        ("lock", "open"): frozenset({"unlocked", "opening"}),
        ("vacuum", "returning"): frozenset({"docked"}),
        ("vacuum", "spot"): frozenset({"cleaning"}),
        ("vacuum", "idle"): frozenset({"paused", "docked"}),
        ("mower", "docked"): frozenset({"returning"}),
    }
)
"""Further reports that mean that the commanded text was obeyed."""

_ON_THE_WAY: Final[Mapping[tuple[str, str], frozenset[str]]] = MappingProxyType(
    {
        ("movement", "open"): frozenset({"opening"}),
        ("movement", "closed"): frozenset({"closing"}),
        ("valve", "open"): frozenset({"opening"}),
        ("valve", "closed"): frozenset({"closing"}),
        ("lock", "locked"): frozenset({"locking"}),
        ("lock", "unlocked"): frozenset({"unlocking"}),
        ("lock", "open"): frozenset({"unlocking"}),
        ("alarm", "disarmed"): frozenset({"disarming", "pending"}),
        **{
            ("alarm", f"armed_{where}"): frozenset({"arming", "pending"})
            for where in ("home", "away", "night", "vacation", "custom_bypass")
        },
    }
)

_MOVES: Final = frozenset({"position", "tilt"})
_COARSE: Final = _MOVES | {"color_temperature"}


def fits(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether a device that reports *seen* has done what *wanted* asked for, with its rounding."""
    match wanted, seen:
        case bool(), bool():
            return wanted is seen
        case str(), str():
            same = wanted.casefold() == seen.casefold()
            return same or seen.casefold() in _SAME.get((capability, wanted.casefold()), ())
        case tuple(), tuple():
            return _fits_numbers(capability, wanted, seen)
        case float(), float():
            if capability == "fan_speed" and _is_next_speed(wanted, seen):
                return True
            slack = _ABSOLUTE.get(capability, _NUMBER)
            if capability in _RELATIVE:
                slack = _RELATIVE[capability] * wanted
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
        if capability in _COARSE:
            return True
        return abs(wanted - seen) <= _STEPS.get(capability, _ROUNDING * abs(wanted))
    if capability == "color" and isinstance(wanted, tuple) and isinstance(seen, tuple):
        return _is_same_color(wanted, seen)
    return True


def is_intermediate(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether *seen* shows that the device is on its way to *wanted*."""
    if isinstance(wanted, str) and isinstance(seen, str):
        return seen.casefold() in _ON_THE_WAY.get((capability, wanted.casefold()), ())
    return capability in _MOVES and isinstance(seen, float)


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
    return capability in {"level", "fan_speed"} and (wanted == 0) != (seen == 0)
