"""Check of a setting against the accepted values of a part. Pure."""

from __future__ import annotations

import math
from typing import Final

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["accepted_values", "check_setting"]

_COLOR: Final = "hue (0 to 360) and saturation (0 to 100), such as 0,100 for red or 240,50 for pale blue"
"""The accepted values of every colour, the one capability with several numbers."""


def check_setting(target: str, part: Part, capability: str, value: PlainValue) -> None:
    """Refuse *value* for *capability* where the part does not accept it.

    Args:
        target: The id of the part, for the error.
        value: The value, in the unit of the vocabulary.

    Raises:
        RefusedError: The message names the accepted values.
    """
    for one in part.capabilities:
        if one.name == capability and one.settable:
            if not isinstance(value, bool):
                _check_value(target, one, value)
            return
    known = ", ".join(dict.fromkeys(one.name for one in part.capabilities if one.settable))
    raise RefusedError(
        f"{capability} of {target}", f"it has no such setting; it takes {known}" if known else "it takes no commands"
    )


def accepted_values(part: Part, capability: str) -> str:
    """Return the values that *part* accepts for *capability*, in words; empty if it cannot be set."""
    for one in part.capabilities:
        if one.name == capability and one.settable:
            return _accepted(one)
    return ""


def _accepted(capability: Capability) -> str:
    known = CAPABILITIES.get(capability.name)
    kind = "text" if known is None else known.kind
    if capability.options:
        return ", ".join(capability.options)
    if kind == "bool":
        return "on or off"
    if kind == "numbers":
        return _COLOR
    return _span(_bounds(capability), capability) if kind == "number" else "a value"


def _check_value(target: str, capability: Capability, value: PlainValue) -> None:
    name = capability.name
    bounds = _bounds(capability)
    if isinstance(value, float) and not (math.isfinite(value) and (not bounds or bounds[0] <= value <= bounds[1])):
        raise RefusedError(f"{value:g} as {name} of {target}", f"it takes {_span(bounds, capability)}")
    if isinstance(value, str) and capability.options and value not in capability.options:
        raise RefusedError(f"{value[:40]!r} as {name} of {target}", f"it takes {', '.join(capability.options)}")


def _span(bounds: tuple[float, ...], capability: Capability) -> str:
    unit = capability.unit or (CAPABILITIES[capability.name].unit if capability.name in CAPABILITIES else "")
    return f"{bounds[0]:g} to {bounds[1]:g} {unit}".rstrip() if bounds else "a finite number"


def _bounds(capability: Capability) -> tuple[float, ...]:
    return capability.bounds or (CAPABILITIES[capability.name].bounds if capability.name in CAPABILITIES else ())
