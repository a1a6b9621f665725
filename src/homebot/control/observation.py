"""Observation of a command by a sensor: the effect, its absence, or neither. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Final, NamedTuple

from homebot.devices.value import PlainValue

__all__ = ["Observed", "observed", "rises", "sensed_by"]


class Observed(Enum):
    """Answer of a sensor about a command."""

    EFFECT = "effect"
    NOTHING = "nothing"
    UNCLEAR = "unclear"


class _Sense(NamedTuple):
    """Signs of an effect in the values of a sensor.

    Attributes:
        least: The smallest change that counts; 0 for a sensor of truths.
        shows_fall: Whether a value that does not fall shows that nothing happened: daylight hides a lamp.
    """

    least: float = 0.0
    shows_fall: bool = True


_SENSES: Final[Mapping[str, _Sense]] = MappingProxyType(
    {
        "contact": _Sense(),
        "unlocked": _Sense(),
        "power": _Sense(1.0),
        "flow": _Sense(0.02),
        "illuminance": _Sense(2.0, shows_fall=False),
    }
)
"""Sensors that show an effect within seconds: people move by themselves, and rooms warm slowly."""

_SENSED_BY: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {
        "on_off": ("illuminance", "power"),
        "level": ("illuminance", "power"),
        "fan_speed": ("power",),
        "position": ("contact",),
        "movement": ("contact",),
        "lock": ("unlocked",),
        "valve": ("flow",),
    }
)
_RISING: Final[Mapping[PlainValue, bool]] = MappingProxyType(
    {True: True, False: False, "open": True, "closed": False, "unlocked": True, "locked": False}
)
_SHARE: Final = 0.1
"""Of the value before, by which a number changes at least."""


def sensed_by(settings: Iterable[str]) -> frozenset[str]:
    """Return the capabilities of sensors that may show a change of *settings*."""
    return frozenset().union(*filter(None, map(_SENSED_BY.get, settings)))


def rises(settings: Mapping[str, PlainValue]) -> bool | None:
    """Return whether a command makes something stronger or opens it; None if that is not certain: a level may dim."""
    for value in settings.values():
        if isinstance(value, float):
            if value == 0.0:
                return False
        elif value in _RISING:
            return _RISING[value]
    return None


def observed(capability: str, before: PlainValue, newest: PlainValue, *, is_rise: bool, is_heard: bool) -> Observed:
    """Return the observation of a rise or a fall by the values of *capability* before the command, and now.

    Args:
        is_heard: Whether the sensor reported after the device.
    """
    sense = _SENSES[capability]
    if isinstance(before, bool) and isinstance(newest, bool):
        if before is is_rise:
            return Observed.UNCLEAR  # it was so before
        return Observed.EFFECT if newest is is_rise else Observed.NOTHING
    if not (isinstance(before, float) and isinstance(newest, float)):
        return Observed.UNCLEAR
    return _observed_number(sense, before, newest, is_rise=is_rise, is_heard=is_heard)


def _observed_number(sense: _Sense, before: float, newest: float, *, is_rise: bool, is_heard: bool) -> Observed:
    change = newest - before if is_rise else before - newest
    if change >= max(sense.least, _SHARE * abs(before)):
        return Observed.EFFECT
    if not is_heard:
        return Observed.UNCLEAR
    is_nothing = newest < sense.least if is_rise else sense.shows_fall and change <= 0.0 < before - sense.least
    return Observed.NOTHING if is_nothing else Observed.UNCLEAR
