"""Merged capabilities of a part, over all the ways to it. Pure."""

from __future__ import annotations

from collections.abc import Sequence

from homebot.devices.device import EVERYTHING
from homebot.devices.part import Capability, Part
from homebot.discovery.merging.matching import SETTING

__all__ = ["decided", "merge_capabilities", "settable_by"]


def merge_capabilities(parts: Sequence[Part]) -> Part:
    """Return the first of *parts* with the capabilities of all of them: it is what they all describe, best first."""
    best = parts[0]
    if len(parts) == 1 or all(one.capabilities == best.capabilities for one in parts):
        return best
    found: dict[str, Capability] = {}
    for part in parts:
        for capability in part.capabilities:
            known = found.get(capability.name)
            found[capability.name] = capability if known is None else _joined(known, capability)
    capabilities = tuple(found.values())
    return best if capabilities == best.capabilities else best.model_copy(update={"capabilities": capabilities})


def decided(parts: Sequence[Part]) -> Part:
    """Return :func:`merge_capabilities` of *parts*, best first; it is a setting where one of them says so.

    Who knows the category decides for all, and of a setting for the type as well: Home Assistant knows no setting that
    is on or off, it calls that a switch.
    """
    whole = merge_capabilities(parts)
    knows = next((one for one in parts if one.category), whole)
    is_setting = knows.service_type == SETTING
    service_type, advertised = (SETTING, knows.advertised) if is_setting else (whole.service_type, whole.advertised)
    if (knows.category, service_type) == (whole.category, whole.service_type):
        return whole
    changes = {"category": knows.category, "service_type": service_type, "advertised": advertised}
    return whole.model_copy(update=changes)


def settable_by(part: Part, whole: Part) -> tuple[str, ...]:
    """Return what can be set by the way that is described as *part*, where all ways together are *whole*."""
    if part is whole:
        return EVERYTHING
    names = _settable(part)
    return EVERYTHING if names == _settable(whole) else tuple(names)


def _settable(part: Part) -> dict[str, None]:
    return {one.name: None for one in part.capabilities if one.settable}


def _joined(best: Capability, other: Capability) -> Capability:
    """Join two capabilities; where only one is settable it decides: its range and options are those of commands."""
    if best == other:
        return best
    shown = other if other.settable and not best.settable else best
    options = shown.options
    if best.settable == other.settable and best.options and other.options:
        options = tuple(dict.fromkeys(best.options + other.options))
    readable, settable = best.readable or other.readable, best.settable or other.settable
    return shown.model_copy(update={"readable": readable, "settable": settable, "options": options})
