"""The description of a part that several announcements describe. Pure."""

from collections.abc import Collection, Sequence
from typing import TypeAlias

from homebot.devices import Sighting
from homebot.devices.device import EVERYTHING
from homebot.devices.part import Capability, Part
from homebot.discovery.merging.matching import SETTING
from homebot.discovery.merging.part_ids import PartPlace

Origin: TypeAlias = tuple[bool, bool, str, str]
"""Whether it is claimed, whether it is not native, gateway, convention. Claimed origins sort last, so that they do not
decide which parts of others are one."""

Way: TypeAlias = tuple[PartPlace, Origin, Part, Sighting]
"""The place of a part, the origin of its announcement, its description, and the announcement."""


def described_part(ways: Sequence[Way]) -> Part:
    """Return the part that *ways* describe, best first, with the capabilities of all; a setting if one of them says so.

    A source that states the category decides it, and for settings also the type, as Home Assistant calls a setting that
    is on or off a switch.
    """
    heard, others = _heard(ways)
    whole = _merge_capabilities(heard + others)
    knows = next((one for one in heard if one.category), whole)
    is_setting = knows.service_type == SETTING
    service_type, advertised = (SETTING, knows.advertised) if is_setting else (whole.service_type, whole.advertised)
    if (knows.category, service_type) == (whole.category, whole.service_type):
        return whole
    changes = {"category": knows.category, "service_type": service_type, "advertised": advertised}
    return whole.model_copy(update=changes)


def settable_by(part: Part, whole: Part) -> tuple[str, ...]:
    """Return the capabilities of *whole* that can be set through the way described as *part*."""
    if part is whole:
        return EVERYTHING
    names = _settable(part)
    return EVERYTHING if names == _settable(whole) else tuple(names)


def _merge_capabilities(parts: Sequence[Part]) -> Part:
    """Return the first of *parts* with the capabilities of all: they describe the same part, best first."""
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


def _heard(ways: Sequence[Way]) -> tuple[list[Part], list[Part]]:
    """Return the parts that decide on type and category, and the others.

    A setting decides if its source is authenticated, or owns the command topics of the loads that it may be, or has
    them too. Otherwise any program could announce it, and would make a harmless setting of a gate.
    """
    loads = [(gateway, one) for (gateway, *_), _, one, _ in ways if not one.category and _settable(one)]
    heard, others = list[Part](), list[Part]()
    for (gateway, *_), _, one, source in ways:
        known = frozenset((*one.writes, *source.owns))
        is_known = source.authenticated or all(at == gateway and _is_below(load.writes, known) for at, load in loads)
        (heard if is_known or not _is_setting(one) else others).append(one)
    return heard, others


def _is_below(topics: Sequence[str], known: Collection[str]) -> bool:
    """Return whether there are *topics*, and each is a *known* one or below one."""
    return bool(topics) and all(any(f"{one}/".startswith(f"{above}/") for above in known) for one in topics)


def _is_setting(part: Part) -> bool:
    return bool(part.category) or part.service_type == SETTING


def _settable(part: Part) -> dict[str, None]:
    return {one.name: None for one in part.capabilities if one.settable}


def _all_options(best: Capability, other: Capability) -> tuple[str, ...]:
    both_have_some = best.options and other.options
    return tuple(dict.fromkeys(best.options + other.options)) if both_have_some else best.options


def _joined(best: Capability, other: Capability) -> Capability:
    """Join two capabilities; if only one is settable, its range and options count, as they are those of commands."""
    if best == other:
        return best
    shown = other if other.settable and not best.settable else best
    options = _all_options(best, other) if best.settable == other.settable else shown.options
    readable, settable = best.readable or other.readable, best.settable or other.settable
    echoed = all(one.echoed for one in (best, other) if one.readable)  # the other one is still readable
    return shown.model_copy(
        update={"readable": readable, "settable": settable, "options": options, "echoed": readable and echoed}
    )
