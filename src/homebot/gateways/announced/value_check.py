"""The check of values against the commands and reports of a part. Pure."""

from __future__ import annotations

import math

from homebot.conventions.command_values import require_bool, require_color, require_number, require_option
from homebot.devices.capabilities import CAPABILITIES, OWN
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
    found = _settable(part, capability)
    kind = CAPABILITIES.get(capability, OWN).kind
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
    found = next((one for one in part.capabilities if one.name == capability and one.readable), None)
    return found is not None and (value is None or _is_of_kind(CAPABILITIES.get(capability, OWN).kind, value))


def _settable(part: Part, capability: str) -> Capability:
    found = {one.name: one for one in part.capabilities if one.settable}
    if capability not in found:
        known = ", ".join(found) or "nothing"
        raise RefusedError(f"{capability[:40]} for the part {part.id[:40]!r}", f"this part takes {known}")
    return found[capability]


def _is_of_kind(kind: str, value: PlainValue) -> bool:
    if kind == "bool":
        return isinstance(value, bool)
    if kind == "number":
        return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)
    if kind == "numbers":
        return isinstance(value, tuple) and all(map(math.isfinite, value))
    return isinstance(value, str)
