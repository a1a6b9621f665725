"""Classification of a thing's affordances: parts with capabilities. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability, Category, Part
from homebot.wot.scale import bounds_of, unit_of
from homebot.wot.thing import Affordance, DataSchema, Form, Thing
from homebot.wot.vocabulary import CAPABILITY_TYPES, LONE_TYPES, NAMES, OWNED, THING_TYPES

__all__ = ["ClassifiedPart", "observe_form", "parts_of", "write_form"]

_OBSERVE_OPS = frozenset({"readproperty", "observeproperty", "subscribeevent"})
_WRITE_OPS = frozenset({"writeproperty", "invokeaction"})
_CATEGORIES: dict[str, Category] = {"config": "config", "diagnostic": "diagnostic"}
_KINDS = {"boolean": "bool", "integer": "number", "number": "number", "string": "text"}
_BY_TYPE = {name: capability for capability, name in CAPABILITY_TYPES.items()}
_TOKEN_BREAK = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|[\s.\-]+")


@dataclass(frozen=True, slots=True)
class ClassifiedPart:
    """A part of a thing, and which affordance each of its capabilities is."""

    part: Part
    affordances: tuple[tuple[Capability, Affordance], ...]


@dataclass(slots=True)
class _One:
    """An affordance and what it was found to be."""

    affordance: Affordance
    capability: str
    guessed: bool
    service_type: str = ""
    part_id: str = ""


def parts_of(thing: Thing) -> tuple[ClassifiedPart, ...]:
    """Return the parts of *thing*.

    What homebot itself wrote into the description counts first, then the semantic types, then names; an affordance of
    which nothing is known has a capability of general meaning. Of two with the same meaning the second is a part of its
    own.
    """
    main = next((device for name, device in THING_TYPES.items() if name in thing.types), "")
    found = [_meaning(one, main) for one in thing.affordances]
    main_is_guess = not main
    if main_is_guess:
        main = _guess([one.capability for one in found if not one.service_type])
    groups: dict[str, list[_One]] = {}
    for one in found:
        groups.setdefault(_group(one, main, groups), []).append(one)
    return tuple(_part(thing, name, members, main, main_is_guess=main_is_guess) for name, members in groups.items())


def observe_form(affordance: Affordance) -> Form | None:
    """Return the form by which it is observed over MQTT, if there is one."""
    return next((one for one in affordance.forms if _is_observable(one)), None)


def write_form(affordance: Affordance) -> Form | None:
    """Return the form by which it is written over MQTT, if there is one."""
    return next((one for one in affordance.forms if _is_writable(one)), None)


def _is_observable(form: Form) -> bool:
    return form.is_mqtt and bool(form.filter) and not _OBSERVE_OPS.isdisjoint(form.ops)


def _is_writable(form: Form) -> bool:
    return form.is_mqtt and bool(form.topic) and not _WRITE_OPS.isdisjoint(form.ops)


def _meaning(one: Affordance, main: str) -> _One:
    written = one.extension
    if written.get("capability") in CAPABILITIES and written.get("serviceType") in DEVICE_TYPES:
        found = _One(one, written["capability"], guessed=False)
        found.service_type, found.part_id = written["serviceType"], written.get("part", "")
        return found
    if one.kind != "property":
        return _One(one, "push" if one.kind == "action" else "press", guessed=False)
    kind = _KINDS.get(one.schema.type, "")
    for name in one.types:
        capability = _in_context(_BY_TYPE.get(name, ""), main)
        if capability and _suits(capability, one.schema):
            return _One(one, capability, guessed=False)
    name = _TOKEN_BREAK.sub("_", one.name.rpartition("/")[2]).strip("_").lower()
    capability = _in_context(NAMES.get(name, name), main)
    if capability in CAPABILITIES and _suits(capability, one.schema):
        return _One(one, capability, guessed=True)
    is_settable = write_form(one) is not None and not one.read_only
    general = {
        "bool": "on_off" if is_settable else "state",
        "number": "number" if is_settable else "measurement",
        "text": ("option" if one.schema.enum else "text") if is_settable else "value",
    }
    return _One(one, general.get(kind, "raw"), guessed=True)


def _in_context(capability: str, main: str) -> str:
    """Return a type by its context: a thermostat's temperature is measured; a level of no lamp may be an opening."""
    if main == "thermostat" and capability == "temperature":
        return "local_temperature"
    if main == "window_covering" and capability == "level":
        return "position"
    if main not in {"", "window_covering", "closure", "water_valve"} and capability == "position":
        return "level"
    return capability


def _suits(capability: str, schema: DataSchema) -> bool:
    expected, kind = CAPABILITIES[capability].kind if capability in CAPABILITIES else "", _KINDS.get(schema.type, "")
    if capability == "color":
        return kind == "text"
    if capability == "lock":
        return kind in {"text", "bool"}
    if expected == "bool":
        return kind == "bool" or (kind == "text" and len(schema.enum) == 2)  # on and off
    return expected == kind


def _guess(capabilities: Iterable[str]) -> str:
    has = set(capabilities)
    if "on_off" in has and has & {"level", "color", "color_temperature"}:
        return "light"
    if "heating_setpoint" in has:
        return "thermostat"
    return next((LONE_TYPES[one] for one in ("lock", "position", "valve", "vacuum", "on_off") if one in has), "")


def _group(one: _One, main: str, groups: dict[str, list[_One]]) -> str:
    """Return the id of the part that *one* belongs to."""
    if one.service_type:
        return one.part_id
    if one.capability in OWNED.get(main, ()) and all(
        other.capability != one.capability for other in groups.get("", [])
    ):
        return ""
    number, name = 1, one.affordance.name
    while name in groups:
        number += 1
        name = f"{one.affordance.name} {number}"
    return name


def _part(thing: Thing, part_id: str, members: list[_One], main: str, *, main_is_guess: bool) -> ClassifiedPart:
    first = members[0]
    if first.service_type:
        service_type, guessed = first.service_type, first.affordance.extension.get("guessed") == "true"
    elif not part_id and main:
        service_type, guessed = main, main_is_guess
    else:
        service_type, guessed = _lone(first), first.guessed
    found = tuple((_capability(one), one.affordance) for one in members)
    listed = [one.affordance for one in members]
    written = first.affordance.extension
    part = Part(
        id=part_id,
        name=written.get("name", "") if first.service_type else first.affordance.title if part_id else "",
        service_type=service_type,
        advertised=written.get("advertised", "") if first.service_type else _advertised(thing, part_id, first),
        tag=written.get("tag", ""),
        category=_CATEGORIES.get(written.get("category", ""), ""),
        guessed=guessed,
        capabilities=tuple(capability for capability, _ in found),
        reads=tuple(dict.fromkeys(form.filter for one in listed for form in one.forms if _is_observable(form))),
        writes=tuple(dict.fromkeys(form.topic for one in listed for form in one.forms if _is_writable(form))),
    )
    return ClassifiedPart(part, found)


def _advertised(thing: Thing, part_id: str, first: _One) -> str:
    types = first.affordance.types if part_id else tuple(one for one in thing.types if one != "Thing")
    return types[0] if types else ""


def _lone(one: _One) -> str:
    settable = write_form(one.affordance) is not None and not one.affordance.read_only
    return LONE_TYPES.get(one.capability, "x_setting" if settable else "x_sensor")


def _capability(one: _One) -> Capability:
    known, schema = CAPABILITIES[one.capability], one.affordance.schema
    readable = observe_form(one.affordance) is not None and not one.affordance.write_only
    settable = write_form(one.affordance) is not None and not one.affordance.read_only
    unit = unit_of(schema) if known.kind == "number" and not known.unit else ""
    options: tuple[str, ...] = ()
    if known.kind == "text" and (one.service_type or one.capability != "lock"):
        options = tuple(text for text in schema.enum if isinstance(text, str))
        options = () if options == known.options else options
    return Capability(
        name=one.capability,
        readable=readable,
        settable=settable,
        unit=unit,
        bounds=_bounds(one) if known.kind == "number" else (),
        options=options,
    )


def _bounds(one: _One) -> tuple[float, ...]:
    """Return the bounds in the vocabulary's unit; none where the vocabulary's own are as narrow."""
    bounds = bounds_of(one.capability, one.affordance)
    return () if bounds == CAPABILITIES[one.capability].bounds else bounds
