"""Values of capabilities: comparison of reported and commanded values, and their text. Pure."""

import math
from collections.abc import Callable, Mapping
from contextlib import suppress
from datetime import datetime, time
from types import MappingProxyType
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, LIGHTS_UP, OWN, SPEED_WORDS
from homebot.devices.capability_type import ValueComparison
from homebot.devices.value import PlainValue

STOPPED: Final = "stopped"
"""The value of a stop command, which is always allowed."""

POWERS: Final = SPEED_WORDS | {"on_off"}
"""The capabilities that turn a part on or off: a true value means on, as any level but 0."""

COLORS: Final = LIGHTS_UP - POWERS
"""Capabilities that turn most lamps on when they are set."""

END_POSITIONS: Final[Mapping[PlainValue, float]] = MappingProxyType({"open": 100.0, "closed": 0.0})
"""The position of each state."""

_HUES: Final = frozenset({"color_temperature", "color"})
"""A lamp shows only one of them: white replaces a colour, and a colour replaces white."""

MODES: Final = frozenset({"fan_mode", "thermostat_mode"})
"""Capabilities that also turn a fan or a thermostat on or off."""

_OPENINGS: Final = frozenset({"movement", "valve", "position"})
_PRESS: Final = "push"
_NEARLY: Final = 1e-3

_ROUNDING: Final = 0.005
"""For a number without a declared fineness: that of its text."""

_NUMBER: Final = 0.51

_HUE: Final = 4.0  # degrees; 254 steps are 1.4 apart, and white has none
_SATURATION: Final = 4.5  # percent; by way of x and y with three digits magenta loses 4
_CIRCLE: Final = 360.0

_VIVID: Final = 70.0
"""Percent of saturation above which hardly any lamp shows all colours (Philips Hue, gamut types A to C)."""

_VIVID_HUE: Final = 30.0
_VIVID_SATURATION: Final = (-10.0, 35.0)
"""How far the nearest colour that a lamp can show may be from a vivid one: most lamps are less saturated."""

_MIN_SPEEDS: Final = 2
_MAX_SPEEDS: Final = 10
_SPEED_ROUNDING: Final = 0.005
"""For speeds: 33 % is the first of three, and 34 % the second."""

_HALF: Final = 0.5

_MAX_TEXT: Final = 40


def fits(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether *seen* is the *wanted* value, allowing for the rounding of devices."""
    match wanted, seen:
        case bool(), bool():
            return wanted is seen
        case str(), str():
            same = wanted.casefold() == seen.casefold() or (capability == "text" and _is_same_moment(wanted, seen))
            return same or seen.casefold() in _comparison_of(capability).accepts.get(wanted.casefold(), ())
        case tuple(), tuple():
            return _fits_numbers(capability, wanted, seen)
        case float(), float():
            if capability == "fan_speed" and _is_next_speed(wanted, seen):
                return True
            known = _comparison_of(capability)
            slack = known.relative_tolerance * wanted if known.relative_tolerance else known.tolerance
            return abs(wanted - seen) <= slack and not is_other_end(capability, wanted, seen)
        case _:
            return wanted is None and seen is None


def is_same(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether *seen* is *wanted* as closely as a device can report, so that a command would change nothing.

    This is stricter than :func:`fits`: half a degree more is a new setpoint, although a device may round to it. For the
    white of a lamp, and for a motor, which stops a little off its goal, both are the same.
    """
    if isinstance(wanted, float) and isinstance(seen, float):
        fineness = _comparison_of(capability).fineness
        is_close = abs(wanted - seen) <= (_ROUNDING * abs(wanted) if fineness is None else fineness)
        return is_close and fits(capability, wanted, seen)
    if not fits(capability, wanted, seen):
        return False
    if capability == "color" and isinstance(wanted, tuple) and isinstance(seen, tuple):
        return _is_same_color(wanted, seen)
    return True


def is_intermediate(capability: str, wanted: PlainValue, seen: PlainValue) -> bool:
    """Return whether *seen* shows that the device is on its way to *wanted*."""
    if isinstance(wanted, str) and isinstance(seen, str):
        return seen.casefold() in _comparison_of(capability).on_the_way.get(wanted.casefold(), ())
    return isinstance(seen, float) and _comparison_of(capability).moves


def _is_same_moment(wanted: str, seen: str) -> bool:
    """Return whether both are one moment or time of day in ISO 8601: ``07:00`` is ``07:00:00``."""
    for kind in (time, datetime) if ":" in wanted and ":" in seen else ():  # 10 and 1000 are other texts
        with suppress(ValueError):
            return kind.fromisoformat(wanted) == kind.fromisoformat(seen)
    return False


def _fits_numbers(capability: str, wanted: tuple[float, ...], seen: tuple[float, ...]) -> bool:
    if len(wanted) != len(seen):
        return False
    if capability != "color" or len(wanted) != 2:
        return all(abs(number - other) <= _NUMBER for number, other in zip(wanted, seen, strict=True))
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
    """Return whether *seen* is the speed to which a fan with few speeds rounds *wanted*: the next higher one."""
    if not 0 < wanted <= seen <= 100:
        return False
    for speeds in range(_MIN_SPEEDS, _MAX_SPEEDS + 1):
        speed = math.ceil(wanted * speeds / 100 - _SPEED_ROUNDING)
        if -_HALF <= speed * 100 / speeds - seen < 1:  # for 66.7 % some report 66 and others 67
            return True
    return False


def is_other_end(capability: str, wanted: float, seen: float) -> bool:
    """Return whether only one of two close levels is 0, which means off, or closed."""
    return _comparison_of(capability).zero_is_off and (wanted == 0) != (seen == 0)


def _comparison_of(capability: str) -> ValueComparison:
    return CAPABILITIES.get(capability, OWN).comparison


def changes(held: str, value: PlainValue, capability: str, wanted: PlainValue) -> bool:
    """Return whether setting *capability* to *wanted* would change the capability *held* from *value*.

    Several capabilities can set the same thing: openness by word or position; power by on, off, level, speed, the
    colour of a lamp or the mode of a fan or thermostat; a lamp's light by colour or white temperature. The effect
    of a press is unknown.
    """
    if capability == held:
        return not _is_same_setting(held, value, wanted)
    for first, other, is_change in _CHANGES:
        if held in first and capability in other:
            return is_change(value, wanted)
    return capability == _PRESS


def related(capability: str) -> tuple[str, ...]:
    """Return all capabilities that set the same thing as *capability*: :func:`changes` compares their values."""
    return _RELATED.get(capability, (capability,))


def departs(capability: str, value: PlainValue, seen: PlainValue) -> bool:
    """Return whether a report of *seen* shows that the device is neither at *value* nor on its way there."""
    if fits(capability, value, seen):
        return False
    return not (isinstance(seen, str) and is_intermediate(capability, value, seen))


def _is_same_setting(capability: str, value: PlainValue, wanted: PlainValue) -> bool:
    """Return whether two commands set the same value; rounding by devices does not matter."""
    if isinstance(value, float) and isinstance(wanted, float):
        return math.isclose(value, wanted, rel_tol=_NEARLY, abs_tol=_NEARLY)
    return fits(capability, value, wanted)


def _is_running(mode: PlainValue) -> bool:
    return not isinstance(mode, str) or mode.casefold() != "off"


def _position(value: PlainValue) -> PlainValue:
    return END_POSITIONS.get(value, value)


_CHANGES: Final[tuple[tuple[frozenset[str], frozenset[str], Callable[[PlainValue, PlainValue], bool]], ...]] = (
    (_OPENINGS, _OPENINGS, lambda value, wanted: not fits("position", _position(value), _position(wanted))),
    (POWERS, POWERS, lambda value, wanted: bool(value) != bool(wanted)),
    (_HUES, _HUES, lambda _value, _wanted: True),
    (POWERS, MODES, lambda value, wanted: bool(value) != _is_running(wanted)),
    (MODES, POWERS, lambda value, wanted: _is_running(value) != bool(wanted)),
    (POWERS, COLORS, lambda value, _wanted: not value),
    (COLORS, POWERS, lambda _value, wanted: not wanted),
)
"""For the held capability and the one that is set: whether the wanted value changes the held one."""

_RELATED: Final = {
    capability: tuple(sorted({capability}.union(*(others for held, others, _ in _CHANGES if capability in held))))
    for group, _, _ in _CHANGES
    for capability in group
}


def value_text(value: PlainValue) -> str:
    """Return *value* in words, at most 40 characters: ``on``, ``21.5``, ``open``."""
    match value:
        case bool():
            return "on" if value else "off"
        case float():
            return _number_text(value)
        case tuple():
            return ", ".join(map(_number_text, value))
        case None:
            return "unknown"
    return value[:_MAX_TEXT]


def _number_text(value: float) -> str:
    """Return a number with at most two decimals: 89 of 255 steps are 34.9 %, not 34.902."""
    return f"{round(value, 2):g}"
