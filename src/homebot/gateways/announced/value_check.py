"""The check of values against the commands and reports of a part. Pure."""

from __future__ import annotations

import math

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.devices.text.states import bounds_of
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError

__all__ = ["can_report", "check_command"]


def check_command(part: Part, capability: str, value: PlainValue) -> None:
    """Check that *capability* of *part* can be set to *value*.

    Raises:
        RefusedError: It cannot; the message names the accepted values.
    """
    for found in part.capabilities:
        if found.name == capability and found.settable:
            break
    else:
        known = ", ".join(dict.fromkeys(one.name for one in part.capabilities if one.settable)) or "nothing"
        raise RefusedError(f"{capability[:40]} for the part {part.id[:40]!r}", f"this part takes {known}")
    kind = _kind(found)
    if kind == "bool":
        require_bool(capability, value)
    elif kind == "number":
        require_number(capability, value, *bounds_of(found), found.unit)
    elif kind == "numbers":
        require_color(value)
    elif found.options:
        require_option(capability, value, found.options)
    elif not isinstance(value, str):
        raise RefusedError(f"{capability} {str(value)[:40]}", "it takes a text")


def can_report(part: Part, capability: str, value: PlainValue) -> bool:
    """Return whether *value* can be one that *part* reports for *capability*; None, for unknown, always can."""
    for found in part.capabilities:
        if found.name == capability and found.readable:
            break
    else:
        return False
    if value is None:
        return True
    kind = _kind(found)
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "number":
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if kind == "numbers":
        return isinstance(value, tuple) and all(math.isfinite(one) for one in value)
    return isinstance(value, str)


def _kind(capability: Capability) -> str:
    known = CAPABILITIES.get(capability.name)
    return "text" if known is None else known.kind
