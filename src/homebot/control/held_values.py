"""Commands that would change a held value of the same part. Pure."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.control.tolerance import fits, is_intermediate
from homebot.devices.value import PlainValue

__all__ = ["COLORS", "END_POSITIONS", "POWERS", "STOPPED", "changes", "departs", "is_on", "related"]

STOPPED: Final = "stopped"
"""The value of a command that stops; it always passes."""

POWERS: Final = frozenset({"on_off", "level", "fan_speed"})
"""The capabilities that turn a part on or off."""

COLORS: Final = frozenset({"color_temperature", "color", "effect"})
"""The capabilities of lamps that turn most of them on when they are set."""

END_POSITIONS: Final[Mapping[PlainValue, float]] = MappingProxyType({"open": 100.0, "closed": 0.0})
"""The positions of what is open and of what is closed."""

_HUES: Final = frozenset({"color_temperature", "color"})
"""Of these a lamp shows one: white takes the place of a colour, and a colour that of white."""

_FAN_MODE: Final = "fan_mode"
"""It turns a fan on, or off."""

_OPENINGS: Final = frozenset({"movement", "valve", "position"})
_RELATED: Final = {
    **{one: tuple(sorted(_OPENINGS)) for one in _OPENINGS},
    **{one: tuple(sorted(POWERS | COLORS | {_FAN_MODE})) for one in POWERS},
    _FAN_MODE: (_FAN_MODE, *sorted(POWERS)),
    "effect": ("effect", *sorted(POWERS)),
    **{one: (*sorted(_HUES), *sorted(POWERS)) for one in _HUES},
}
_PRESS: Final = "push"
_NEARLY: Final = 1e-3


def changes(held: str, value: PlainValue, capability: str, wanted: PlainValue) -> bool:
    """Return whether setting *capability* to *wanted* would change the capability *held* from *value*.

    Openness is one thing, by word or by position; so is power, by on, off, level, speed, the colour of a lamp or the
    mode of a fan; and so is its light, by colour or by the temperature of its white. What a press does is not known.
    """
    if capability == held:
        return not _is_same_setting(held, value, wanted)
    if {held, capability} <= _OPENINGS:
        return not fits("position", _position(value), _position(wanted))
    if {held, capability} <= POWERS:
        return is_on(value) != is_on(wanted)
    if {held, capability} == _HUES:
        return True
    if held in POWERS and capability == _FAN_MODE:
        return is_on(value) != _is_running(wanted)
    if held == _FAN_MODE and capability in POWERS:
        return _is_running(value) != is_on(wanted)
    if held in POWERS and capability in COLORS:
        return not is_on(value)
    if held in COLORS and capability in POWERS:
        return not is_on(wanted)
    return capability == _PRESS


def related(capability: str) -> tuple[str, ...]:
    """Return the capabilities, *capability* too, that set the same thing: :func:`changes` compares their values."""
    return _RELATED.get(capability, (capability,))


def departs(capability: str, value: PlainValue, seen: PlainValue) -> bool:
    """Return whether a report of *seen* shows that the device is not at *value*, nor on its way there."""
    if fits(capability, value, seen):
        return False
    return not (isinstance(seen, str) and is_intermediate(capability, value, seen))


def _is_same_setting(capability: str, value: PlainValue, wanted: PlainValue) -> bool:
    """Return whether two commands set the same; what devices round does not matter."""
    if isinstance(value, float) and isinstance(wanted, float):
        return math.isclose(value, wanted, rel_tol=_NEARLY, abs_tol=_NEARLY)
    return fits(capability, value, wanted)


def _is_running(mode: PlainValue) -> bool:
    return not isinstance(mode, str) or mode.casefold() != "off"


def _position(value: PlainValue) -> PlainValue:
    return END_POSITIONS.get(value, value)


def is_on(value: PlainValue) -> bool:
    """Return whether *value* of one of :data:`POWERS` is on: a dimmed lamp is."""
    return value is not None and value is not False and value != 0.0
