"""Commands that would change a held value of the same part. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from homebot.control.tolerance import fits, is_intermediate
from homebot.devices.value import PlainValue

__all__ = ["END_POSITIONS", "POWERS", "STOPPED", "changes", "departs", "is_on", "related"]

STOPPED: Final = "stopped"
"""The value of a command that stops; it always passes."""

POWERS: Final = frozenset({"on_off", "level", "fan_speed"})
"""The capabilities that turn a part on or off."""

END_POSITIONS: Final[Mapping[PlainValue, float]] = MappingProxyType({"open": 100.0, "closed": 0.0})
"""The positions of what is open and of what is closed."""

_OPENINGS: Final = frozenset({"movement", "valve", "position"})
_RELATED: Final = {one: tuple(sorted(group)) for group in (_OPENINGS, POWERS) for one in group}
_PRESS: Final = "push"


def changes(held: str, value: PlainValue, capability: str, wanted: PlainValue) -> bool:
    """Return whether setting *capability* to *wanted* would change the capability *held* from *value*.

    Openness is one thing, by word or by position; so is power, by on, off, level or speed. What a press does is not
    known.
    """
    if capability == held:
        return not fits(held, value, wanted)
    if {held, capability} <= _OPENINGS:
        return not fits("position", _position(value), _position(wanted))
    if {held, capability} <= POWERS:
        return is_on(value) != is_on(wanted)
    return capability == _PRESS


def related(capability: str) -> tuple[str, ...]:
    """Return the capabilities, *capability* too, that set the same thing: :func:`changes` compares their values."""
    return _RELATED.get(capability, (capability,))


def departs(capability: str, value: PlainValue, seen: PlainValue) -> bool:
    """Return whether a report of *seen* shows that the device is not at *value*, nor on its way there."""
    if fits(capability, value, seen):
        return False
    return not (isinstance(seen, str) and is_intermediate(capability, value, seen))


def _position(value: PlainValue) -> PlainValue:
    return END_POSITIONS.get(value, value)


def is_on(value: PlainValue) -> bool:
    """Return whether *value* of one of :data:`POWERS` is on: a dimmed lamp is."""
    return value is not None and value is not False and value != 0.0
