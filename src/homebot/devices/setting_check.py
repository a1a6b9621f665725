"""Check of a setting against the accepted values of a part. Pure."""

from __future__ import annotations

import math
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, OWN, settable_options
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["accepted_values", "check_setting"]

_HUE, _SATURATION = 360, 100
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
            if not _is_taken(one, value):
                shown = f"{value:g}" if isinstance(value, float) else f"{value!r:.40}"
                accepted = "True or False" if CAPABILITIES.get(capability, OWN).kind == "bool" else _accepted(one)
                raise RefusedError(f"{shown} as {capability} of {target}", f"it takes {accepted}")
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
    known = CAPABILITIES.get(capability.name, OWN)
    if options := capability.options or known.options:
        return ", ".join(settable_options(capability.name, options))
    match known.kind:
        case "bool":
            return "on or off"
        case "numbers":
            return _COLOR
        case "number":
            bounds, unit = capability.bounds or known.bounds, capability.unit or known.unit
            return f"{bounds[0]:g} to {bounds[1]:g} {unit}".rstrip() if bounds else "a finite number"
    return "a text"


def _is_taken(capability: Capability, value: PlainValue) -> bool:
    """Return whether *value* is of the kind of *capability*, and one that it accepts; that of an own one may be any."""
    known = CAPABILITIES.get(capability.name, OWN)
    kind = known.kind
    match value:
        case bool():
            return kind in ("bool", "")
        case float():
            bounds = capability.bounds or known.bounds
            return kind in ("number", "") and math.isfinite(value) and (not bounds or bounds[0] <= value <= bounds[1])
        case str():
            return kind in ("text", "") and (
                not capability.options or value in settable_options(capability.name, capability.options)
            )
        case (float() | int() as hue, float() | int() as saturation):
            return kind in ("numbers", "") and 0 <= hue <= _HUE and 0 <= saturation <= _SATURATION
    return False
