"""Classification of a thing's affordances: parts with capabilities. Pure."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace

from homebot.conventions.entity_rows import climate_type, setpoints_of
from homebot.conventions.units import measured_in
from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability, Category, Part, payload_digest
from homebot.integrations.things.formats.binding import Binding, ClassifiedAffordance, ClassifiedPart
from homebot.integrations.things.formats.payload import is_rgb
from homebot.integrations.things.formats.scale import bounds_of, unit_of
from homebot.integrations.things.formats.thing import Affordance, DataSchema, Form, Thing
from homebot.integrations.things.formats.vocabulary import (
    CAPABILITY_TYPES,
    LOCK_ACTIONS,
    LONE_TYPES,
    NAMES,
    OWNED,
    THING_TYPES,
)
from homebot.support.folding import fold, words_of

_CATEGORIES: dict[str, Category] = {"config": "config", "diagnostic": "diagnostic"}
_KINDS = {"boolean": "bool", "integer": "number", "number": "number", "string": "text"}
_GENERAL = {"bool": ("state", "on_off"), "number": ("measurement", "number"), "text": ("value", "text")}
"""The capabilities for values of unknown meaning, read-only and settable, by kind of value."""

_BY_TYPE = {name: capability for capability, name in CAPABILITY_TYPES.items()}
_TOKEN_BREAK = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|[\s.\-]+")


@dataclass(slots=True)
class _Candidate:
    """An affordance and its classification.

    Attributes:
        doubt: The evidence for its capability: 0 its description, 1 its name, 2 only its kind of value.
    """

    affordance: Affordance
    observed: tuple[Form, ...]
    written: tuple[Form, ...]
    capability: str = ""
    guessed: bool = False
    doubt: int = 0
    service_type: str = ""
    part_id: str = ""
    actions: dict[str, _Candidate] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of the affordance, followed by that of the member if its value is an object."""
        member = self.affordance.schema.member if self.affordance.schema.members else ""
        return f"{self.affordance.name}/{member}" if member else self.affordance.name

    @property
    def is_written(self) -> bool:
        return bool(self.written) and not self.affordance.read_only

    @property
    def is_settable(self) -> bool:
        return self.is_written or bool(self.actions)

    @property
    def is_readable(self) -> bool:
        return bool(self.observed) and not self.affordance.write_only


def parts_of(thing: Thing, binding: Binding) -> tuple[ClassifiedPart, ...]:
    """Return the parts of *thing* that one protocol can use.

    homebot's own terms in the description take precedence, then semantic types, then names; an affordance of unknown
    meaning gets a generic capability. Of two with the same meaning, the less certain one, or else the second, becomes a
    separate part.

    Args:
        binding: The protocol's choice among forms; an affordance without a usable form can be neither read nor set.
    """
    main = next((device for name, device in THING_TYPES.items() if name in thing.types), "")
    found = [one for affordance in thing.affordances for one in _split(affordance, binding)]
    for one in found:
        _find_meaning(one, main)
    found = _with_lock_actions(found)
    unknown, main_is_guess = [one for one in found if not one.service_type], not main
    if main_is_guess:
        main = "thermostat" if _assign_thermostat(unknown) else _guess(unknown, thing.title)
    kind = _climate_type(unknown) if main == "thermostat" else main
    groups = _groups(found, _owned(found, main))
    return tuple(_part(thing, name, members, kind, main_is_guess=main_is_guess) for name, members in groups.items())


def _split(affordance: Affordance, binding: Binding) -> Iterator[_Candidate]:
    """Yield an affordance; of a read-only object, each member with a single value."""
    observed, written = binding.observe_forms(affordance), binding.write_forms(affordance)
    members = affordance.schema.members
    if affordance.kind != "property" or not members or (written and not affordance.read_only):
        yield _Candidate(affordance, observed, written)
        return
    for name, schema in members:
        title = f"{affordance.title} {name}" if affordance.title else ""
        yield _Candidate(replace(affordance, title=title, schema=replace(schema, members=members)), observed, ())


def _with_lock_actions(found: list[_Candidate]) -> list[_Candidate]:
    """Return *found* with the actions of a lock as commands for its read-only state."""
    lock = next((one for one in found if one.capability == "lock" and not one.is_settable), None)
    if lock is not None:
        acting = [(one, name) for one in found for name in one.affordance.types if name in LOCK_ACTIONS and one.written]
        lock.actions = {LOCK_ACTIONS[name]: one for one, name in acting}
        found = [one for one in found if not any(one is each for each in lock.actions.values())]
    return found


def _find_meaning(one: _Candidate, main: str) -> None:
    """Set the meaning of an affordance, by its declaration, its semantic types, its name or its kind of value."""
    declared = one.affordance.extension
    if declared.get("capability") in CAPABILITIES and declared.get("serviceType") in DEVICE_TYPES:
        one.capability, one.service_type = declared["capability"], declared["serviceType"]
        one.part_id = declared.get("part", "")
    elif one.affordance.kind != "property":
        one.capability = _invoked(one) if one.affordance.kind == "action" else "press"
    elif capability := _by_type(one.affordance, main):
        one.capability = capability
    elif capability := _by_options(one):
        one.capability, one.guessed, one.doubt = capability, True, 1
    else:
        one.guessed = True
        one.capability, one.doubt = _by_name(one, main), 1
        if one.capability not in CAPABILITIES or not _suits(one.capability, one.affordance.schema):
            one.capability, one.doubt = _measured(one) or _general(one), 2


def _invoked(one: _Candidate) -> str:
    """Return the capability of an action: a setting if it takes a number or a text, such as the time of ``fade``."""
    takes = _KINDS.get(one.affordance.schema.type)
    return _general(one) if one.is_written and takes in {"number", "text"} else "push"


def _by_type(affordance: Affordance, main: str) -> str:
    """Return the capability of the first semantic type that fits the values; empty for none."""
    for name in () if affordance.schema.members else affordance.types:
        capability = _in_context(_of_type(name, affordance, main), main)
        if capability and _suits(capability, affordance.schema):
            return capability
    return ""


def _of_type(name: str, affordance: Affordance, main: str) -> str:
    """Return the capability of a semantic type; WebThings use one for both setpoints, and one for all levels."""
    if name == "TargetTemperatureProperty" and "cool" in affordance.name.casefold():
        return "cooling_setpoint"
    if name == "LevelProperty" and affordance.read_only and main not in _OPENINGS:
        return "measurement"  # of humidity or a tank
    return _BY_TYPE.get(name, "")


def _by_options(one: _Candidate) -> str:
    """Return the capability identified by options alone: a lock, except of keys, or an alarm."""
    words = {text.casefold() for text in one.affordance.schema.enum if isinstance(text, str)}
    found = next((capability for capability, needed in _OPTIONS.items() if needed <= words), "")
    return "" if found == "lock" and not _KEYS.isdisjoint(_words_of(one)) else found


_OPTIONS: Mapping[str, frozenset[str]] = {"lock": frozenset({"locked", "unlocked"}), "alarm": frozenset({"disarmed"})}
_KEYS = frozenset({"child", "key", "keypad", "keys"})


def _by_name(one: _Candidate, main: str) -> str:
    """Return the capability suggested by the name, or the name."""
    name = _TOKEN_BREAK.sub("_", one.name.rpartition("/")[2]).strip("_").lower()
    if name in {"power", "state"} and one.is_settable and _is_switch(one.affordance.schema):
        return "on_off"  # and no watts, nor read-only properties
    return _in_context(NAMES.get(name, name), main)


def _general(one: _Candidate) -> str:
    """Return the capability of a value of unknown meaning, by its kind."""
    kind = _KINDS.get(one.affordance.schema.type, "")
    if kind == "text" and one.is_settable and one.affordance.schema.enum:
        return "option"
    return _GENERAL.get(kind, ("raw", "raw"))[one.is_settable]


def _is_switch(schema: DataSchema) -> bool:
    words = {text.casefold() for text in schema.enum if isinstance(text, str)}
    return schema.type == "boolean" or words == {"on", "off"}


def _measured(one: _Candidate) -> str:
    """Return the capability implied by the unit of a read-only number."""
    is_measured = not one.is_settable and _KINDS.get(one.affordance.schema.type) == "number"
    return measured_in(unit_of(one.affordance.schema)[:40]) if is_measured else ""


def _in_context(capability: str, main: str) -> str:
    """Return a capability in context: a thermostat's temperature is measured; a level may be an opening."""
    if main == "thermostat" and capability == "temperature":
        return "local_temperature"
    if main == "window_covering" and capability == "level":
        return "position"
    if main not in {"", *_OPENINGS} and capability == "position":
        return "level"
    return capability


_OPENINGS = frozenset({"window_covering", "closure", "water_valve"})


def _suits(capability: str, schema: DataSchema) -> bool:
    expected, kind = CAPABILITIES.get(capability, OWN).kind, _KINDS.get(schema.type, "")
    if capability == "color":
        return kind == "text" or is_rgb(schema)
    if capability == "lock":
        return kind in {"text", "bool"}
    if expected == "bool":
        return kind == "bool" or (kind == "text" and len(schema.enum) == 2)  # on and off
    return expected == kind


def _guess(found: Collection[_Candidate], title: str) -> str:
    """Return the type suggested by the capabilities; a part with a level that is called a valve is not a lamp."""
    has = {one.capability for one in found}
    is_dimmed = any(one.capability == "level" and one.name != "level" for one in found)
    is_other = not is_dimmed and not _NO_LAMPS.isdisjoint(words_of(title))
    if "on_off" in has and has & {"color", "color_temperature", *(() if is_other else ("level",))}:
        return "light"
    if "heating_setpoint" in has:
        return "thermostat"
    return next((LONE_TYPES[one] for one in ("lock", "position", "valve", "vacuum", "on_off") if one in has), "")


_NO_LAMPS = frozenset(
    {"boiler", "door", "fan", "gate", "heater", "irrigation", "kettle", "motor", "oven", "pump", "sprinkler", "valve"}
)
"""Words in a title that exclude a level of light."""


def _assign_thermostat(found: Collection[_Candidate]) -> bool:
    """Assign the meanings of a thermostat to a temperature, setpoint and mode of *found*; return False without them."""
    roles = {
        "local_temperature": [one for one in found if _is_indoors(one)],
        "heating_setpoint": [one for one in found if one.capability == "heating_setpoint" or _is_setpoint(one)],
        "thermostat_mode": [one for one in found if one.capability == "thermostat_mode" or _is_mode(one)],
    }
    if any(len(ones) != 1 for ones in roles.values()):
        return False
    for capability, (one,) in roles.items():
        one.capability = capability
    return True


def _climate_type(found: Collection[_Candidate]) -> str:
    """Return the type of a thermostat by its modes; if none of them heats, its setpoint becomes one for cooling."""
    options = [text for one in found if one.capability == "thermostat_mode" for text in one.affordance.schema.enum]
    modes = [fold(str(text)) for text in options]
    for one in found:
        if one.capability == "heating_setpoint" and "heating_setpoint" not in setpoints_of(modes):
            one.capability = "cooling_setpoint"
    return climate_type(modes)


def _is_indoors(one: _Candidate) -> bool:
    return one.capability == "temperature" and not one.is_settable and _OUTDOORS.isdisjoint(_words_of(one))


def _is_setpoint(one: _Candidate) -> bool:
    in_degrees = unit_of(one.affordance.schema) in {"°C", "°F"}
    return one.capability == "number" and in_degrees and not _SETPOINTS.isdisjoint(_words_of(one))


def _is_mode(one: _Candidate) -> bool:
    is_choice = one.capability == "option" and "mode" in _words_of(one)
    return is_choice and not _MODES.isdisjoint(fold(str(text)) for text in one.affordance.schema.enum)


def _words_of(one: _Candidate) -> tuple[str, ...]:
    return words_of(_TOKEN_BREAK.sub("_", one.name))


_OUTDOORS = frozenset({"outdoor", "outside"})
_SETPOINTS = frozenset({"desired", "set", "setpoint", "target"})
_MODES = frozenset({"auto", "cool", "cooling", "heat", "heating"})


def _owned(found: Iterable[_Candidate], main: str) -> dict[str, _Candidate]:
    """Return the affordances of the main part by capability: of a switch and a child lock, the switch."""
    owned: dict[str, _Candidate] = {}
    for one in sorted(found, key=lambda each: (not each.service_type, each.doubt, not each.is_settable)):
        if one.part_id == "" if one.service_type else one.capability in OWNED.get(main, ()):
            owned.setdefault(one.capability, one)
    return owned


def _groups(found: Iterable[_Candidate], owned: Mapping[str, _Candidate]) -> dict[str, list[_Candidate]]:
    """Return the affordances of each part by its id."""
    groups: dict[str, list[_Candidate]] = {}
    for one in found:
        groups.setdefault(_group(one, owned, groups), []).append(one)
    return groups


def _group(one: _Candidate, owned: Mapping[str, _Candidate], groups: dict[str, list[_Candidate]]) -> str:
    """Return the id of the part of *one*."""
    if one.service_type:
        return one.part_id
    if owned.get(one.capability) is one:
        return ""
    number, name = 1, one.name
    while name in groups:
        number += 1
        name = f"{one.name} {number}"
    return name


def _part(thing: Thing, part_id: str, members: list[_Candidate], main: str, *, main_is_guess: bool) -> ClassifiedPart:
    first, found = members[0], tuple(_classified(one) for one in members)
    declared = first.affordance.extension
    if first.service_type:
        service_type, guessed = first.service_type, declared.get("guessed") == "true"
        name, advertised = declared.get("name", ""), declared.get("advertised", "")
    elif part_id:
        service_type, guessed, name = _lone(first), first.guessed, first.affordance.title
        advertised = _advertised_type(thing, first)
    else:
        service_type, guessed = (main, main_is_guess) if main else (_lone(first), first.guessed)
        name, advertised = "", _advertised_type(thing, None)
    part = Part(
        id=part_id,
        name=name,
        service_type=service_type,
        advertised=advertised,
        tag=declared.get("tag", ""),
        category=_CATEGORIES.get(declared.get("category", ""), ""),
        guessed=guessed,
        capabilities=tuple(one.capability for one in found),
        reads=_distinct(form.filter for one in members for form in one.observed),
        writes=_distinct(form.topic for one in _with_actions(members) for form in one.written),
        payloads=_payloads(found),
    )
    return ClassifiedPart(part, found)


def _with_actions(members: Iterable[_Candidate]) -> list[_Candidate]:
    return [each for one in members for each in (one, *one.actions.values())]


def _distinct(texts: Iterable[str]) -> tuple[str, ...]:
    """Return the non-empty *texts*, each once."""
    return tuple(dict.fromkeys(filter(None, texts)))


def _advertised_type(thing: Thing, first: _Candidate | None) -> str:
    """Return the type stated by the first affordance of a part, or else that of the thing."""
    types = [one for one in thing.types if one != "Thing"] if first is None else first.affordance.types
    return next(iter(types), "")


def _payloads(found: tuple[ClassifiedAffordance, ...]) -> str:
    """Return the digest of the written payloads and their addresses; empty if nothing can be set."""
    written = [
        (one.capability.name, value, each.affordance.name, each.affordance.schema, each.written)
        for one in found
        for value, each in (("", one), *one.actions.items())
        if each.written is not None
    ]
    return payload_digest(written) if written else ""


def _lone(one: _Candidate) -> str:
    own = LONE_TYPES.get(one.capability) or CAPABILITIES[one.capability].sensor
    if not own and one.affordance.kind == "action":
        return LONE_TYPES["push"]  # it takes a value
    return own or ("x_setting" if one.is_settable else "x_sensor")


def _classified(one: _Candidate) -> ClassifiedAffordance:
    known, schema = CAPABILITIES[one.capability], one.affordance.schema
    is_number = known.kind == "number"
    bounds = bounds_of(one.capability, one.affordance) if is_number else ()
    options = _options(one) if known.kind == "text" else ()
    capability = Capability(
        name=one.capability,
        readable=one.is_readable,
        settable=one.is_settable,
        unit=unit_of(schema) if is_number and not known.unit else "",
        bounds=() if bounds == known.bounds else bounds,
        options=() if options == known.options else options,
    )
    observed = one.observed[0] if one.is_readable else None
    written = one.written[0] if one.is_written else None
    actions = {value: _classified(action) for value, action in one.actions.items()}
    return ClassifiedAffordance(capability, one.affordance, observed, written, actions)


def _options(one: _Candidate) -> tuple[str, ...]:
    if one.capability == "lock" and not one.service_type:
        return ()
    return tuple(text for text in one.affordance.schema.enum if isinstance(text, str))
