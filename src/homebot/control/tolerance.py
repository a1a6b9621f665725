"""Comparison of a reported value with the one that was commanded. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["fits", "is_intermediate"]

_ABSOLUTE: Final[Mapping[str, float]] = MappingProxyType(
    {"level": 1.5, "position": 3.0, "tilt": 3.0, "fan_speed": 5.0, "volume": 1.5, "humidity_setpoint": 1.0}
)
"""By how many units a device may round: most count a percentage in 100 or 254 steps, motors stop a little off."""

_RELATIVE: Final[Mapping[str, float]] = MappingProxyType({"color_temperature": 0.02})
"""Whole mireds are up to 1.3 % of a cold white apart (Matter 1.6 application clusters, section 3.2.7)."""

_NUMBER: Final = 0.51
"""Of numbers without a rule, such as temperatures: most devices take halves."""

_HUE: Final = 4.0  # degrees; 254 steps are 1.4 apart, and white has none
_SATURATION: Final = 3.0  # percent
_CIRCLE: Final = 360.0

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
            slack = _ABSOLUTE.get(capability, _NUMBER)
            if capability in _RELATIVE:
                slack = _RELATIVE[capability] * wanted
            return abs(wanted - seen) <= slack and not _is_other_end(capability, wanted, seen)
        case _:
            return wanted is None and seen is None


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
    around = abs(wanted[0] - seen[0]) % _CIRCLE
    is_white = wanted[1] <= _SATURATION
    return abs(wanted[1] - seen[1]) <= _SATURATION and (is_white or min(around, _CIRCLE - around) <= _HUE)


def _is_other_end(capability: str, wanted: float, seen: float) -> bool:
    """Return whether one of two close levels is 0, which is off, or closed."""
    return capability in {"level", "fan_speed"} and (wanted == 0) != (seen == 0)
