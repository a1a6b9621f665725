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
from homebot.integrations.things.formats.payload import bounds_of, is_rgb, unit_of
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
    candidates = [candidate for affordance in thing.affordances for candidate in _split(affordance, binding)]
    for candidate in candidates:
        _find_meaning(candidate, main)
    candidates = _with_lock_actions(candidates)
    unknown, main_is_guess = [candidate for candidate in candidates if not candidate.service_type], not main
    if main_is_guess:
        main = _guess(unknown, thing.title)
    kind = _climate_type(unknown) if main == "thermostat" else main
    owned: dict[str, _Candidate] = {}
    for candidate in sorted(candidates, key=lambda entry: (not entry.service_type, entry.doubt, not entry.is_settable)):
        if candidate.part_id == "" if candidate.service_type else candidate.capability in OWNED.get(main, ()):
            owned.setdefault(candidate.capability, candidate)
    groups: dict[str, list[_Candidate]] = {}
    for candidate in candidates:
        groups.setdefault(_group(candidate, owned, groups), []).append(candidate)
    return tuple(_part(thing, name, members, kind, main_is_guess=main_is_guess) for name, members in groups.items())


def _with_lock_actions(candidates: list[_Candidate]) -> list[_Candidate]:
    """Return *candidates* with the actions of a lock as commands for its read-only state."""
    locks = [candidate for candidate in candidates if candidate.capability == "lock" and not candidate.is_settable]
    if not locks:
        return candidates
    acting = [
        (candidate, name)
        for candidate in candidates
        for name in candidate.affordance.types
        if name in LOCK_ACTIONS and candidate.written
    ]
    locks[0].actions = {LOCK_ACTIONS[name]: candidate for candidate, name in acting}
    used = [*locks[0].actions.values()]
    return [candidate for candidate in candidates if not any(candidate is action for action in used)]


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


def _find_meaning(candidate: _Candidate, main: str) -> None:
    """Set the meaning of an affordance, by its declaration, its semantic types, its name or its kind of value."""
    declared = candidate.affordance.extension
    if declared.get("capability") in CAPABILITIES and declared.get("serviceType") in DEVICE_TYPES:
        candidate.capability, candidate.service_type = declared["capability"], declared["serviceType"]
        candidate.part_id = declared.get("part", "")
    elif candidate.affordance.kind != "property":
        candidate.capability = "press"
        if candidate.affordance.kind == "action":  # a setting if it takes a number or a text, as the time of ``fade``
            is_setting = candidate.is_written and _KINDS.get(candidate.affordance.schema.type) in {"number", "text"}
            candidate.capability = _general(candidate) if is_setting else "push"
    elif capability := _by_type(candidate.affordance, main):
        candidate.capability = capability
    elif capability := _by_options(candidate):
        candidate.capability, candidate.guessed, candidate.doubt = capability, True, 1
    else:
        candidate.guessed = True
        candidate.capability, candidate.doubt = _by_name(candidate, main), 1
        if candidate.capability not in CAPABILITIES or not _suits(candidate.capability, candidate.affordance.schema):
            candidate.capability, candidate.doubt = _measured(candidate) or _general(candidate), 2


def _by_type(affordance: Affordance, main: str) -> str:
    """Return the capability of the first semantic type that fits the values; empty for none."""
    for name in () if affordance.schema.members else affordance.types:
        if name == "TargetTemperatureProperty" and "cool" in affordance.name.casefold():
            known = "cooling_setpoint"
        elif name == "LevelProperty" and affordance.read_only and main not in _OPENINGS:
            known = "measurement"  # of humidity or a tank
        else:
            known = _BY_TYPE.get(name, "")
        capability = _in_context(known, main)
        if capability and _suits(capability, affordance.schema):
            return capability
    return ""


def _by_options(candidate: _Candidate) -> str:
    """Return the capability identified by options alone: a lock, except of keys, or an alarm."""
    words = {text.casefold() for text in candidate.affordance.schema.enum if isinstance(text, str)}
    capability_found = next((capability for capability, needed in _OPTIONS.items() if needed <= words), "")
    return "" if capability_found == "lock" and not _KEYS.isdisjoint(_words_of(candidate)) else capability_found


_OPTIONS: Mapping[str, frozenset[str]] = {"lock": frozenset({"locked", "unlocked"}), "alarm": frozenset({"disarmed"})}
_KEYS = frozenset({"child", "key", "keypad", "keys"})


def _by_name(candidate: _Candidate, main: str) -> str:
    """Return the capability suggested by the name, or the name."""
    name = _TOKEN_BREAK.sub("_", candidate.name.rpartition("/")[2]).strip("_").lower()
    schema = candidate.affordance.schema
    words = {text.casefold() for text in schema.enum if isinstance(text, str)}
    is_switch = schema.type == "boolean" or words == {"on", "off"}
    if name in {"power", "state"} and candidate.is_settable and is_switch:
        return "on_off"  # and no watts, nor read-only properties
    return _in_context(NAMES.get(name, name), main)


def _general(candidate: _Candidate) -> str:
    """Return the capability of a value of unknown meaning, by its kind."""
    kind = _KINDS.get(candidate.affordance.schema.type, "")
    if kind == "text" and candidate.is_settable and candidate.affordance.schema.enum:
        return "option"
    return _GENERAL.get(kind, ("raw", "raw"))[candidate.is_settable]


def _measured(candidate: _Candidate) -> str:
    """Return the capability implied by the unit of a read-only number."""
    is_measured = not candidate.is_settable and _KINDS.get(candidate.affordance.schema.type) == "number"
    return measured_in(unit_of(candidate.affordance.schema)[:40]) if is_measured else ""


def _in_context(capability: str, main: str) -> str:
    """Return a capability in context: a thermostat's temperature is measured; a level may be an opening."""
    if main == "thermostat" and capability == "temperature":
        return "local_temperature"
    if main == "x_lift" and capability == "door":
        return "movement"
    if main != "x_lift" and capability in {"floor", "session"}:
        return ""
    if main == "window_covering" and capability == "level":
        return "position"
    if main not in {"", *_OPENINGS} and capability == "position":
        return "level"
    return capability


_OPENINGS = frozenset({"window_covering", "closure", "water_valve", "x_lift"})


def _suits(capability: str, schema: DataSchema) -> bool:
    expected, kind = CAPABILITIES.get(capability, OWN).kind, _KINDS.get(schema.type, "")
    if capability == "color":
        return kind == "text" or is_rgb(schema)
    if capability == "lock":
        return kind in {"text", "bool"}
    if expected == "bool":
        return kind == "bool" or (kind == "text" and len(schema.enum) == 2)  # on and off
    return expected == kind


def _guess(candidates: Collection[_Candidate], title: str) -> str:
    """Return the type suggested by the capabilities; a part with a level that is called a valve is not a lamp."""
    has = {candidate.capability for candidate in candidates}
    is_dimmed = any(candidate.capability == "level" and candidate.name != "level" for candidate in candidates)
    is_other = not is_dimmed and not _NO_LAMPS.isdisjoint(words_of(title))
    if "on_off" in has and has & {"color", "color_temperature", *(() if is_other else ("level",))}:
        return "light"
    if "heating_setpoint" in has:
        return "thermostat"
    return next(
        (
            LONE_TYPES[capability]
            for capability in ("lock", "position", "valve", "vacuum", "on_off")
            if capability in has
        ),
        "",
    )


_NO_LAMPS = frozenset(
    {"boiler", "door", "fan", "gate", "heater", "irrigation", "kettle", "motor", "oven", "pump", "sprinkler", "valve"}
)
"""Words in a title that exclude a level of light."""


def _climate_type(candidates: Collection[_Candidate]) -> str:
    """Return the type of a thermostat by its modes; if none of them heats, its setpoint becomes one for cooling."""
    options = [
        text
        for candidate in candidates
        if candidate.capability == "thermostat_mode"
        for text in candidate.affordance.schema.enum
    ]
    modes = [fold(str(text)) for text in options]
    for candidate in candidates:
        if candidate.capability == "heating_setpoint" and "heating_setpoint" not in setpoints_of(modes):
            candidate.capability = "cooling_setpoint"
    return climate_type(modes)


def _words_of(candidate: _Candidate) -> tuple[str, ...]:
    return words_of(_TOKEN_BREAK.sub("_", candidate.name))


def _group(candidate: _Candidate, owned: Mapping[str, _Candidate], groups: dict[str, list[_Candidate]]) -> str:
    """Return the id of the part of *candidate*."""
    if candidate.service_type:
        return candidate.part_id
    if owned.get(candidate.capability) is candidate:
        return ""
    number, name = 1, candidate.name
    while name in groups:
        number += 1
        name = f"{candidate.name} {number}"
    return name


def _part(thing: Thing, part_id: str, members: list[_Candidate], main: str, *, main_is_guess: bool) -> ClassifiedPart:
    first, affordances = members[0], tuple(_classify(member) for member in members)
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
    written = [
        (affordance.capability.name, value, source.affordance.name, source.affordance.schema, source.written)
        for affordance in affordances
        for value, source in (("", affordance), *affordance.actions.items())
        if source.written is not None
    ]
    part = Part(
        id=part_id,
        name=name,
        service_type=service_type,
        advertised=advertised,
        tag=declared.get("tag", ""),
        category=_CATEGORIES.get(declared.get("category", ""), ""),
        guessed=guessed,
        capabilities=tuple(affordance.capability for affordance in affordances),
        reads=_distinct(form.filter for member in members for form in member.observed),
        writes=_distinct(
            form.topic
            for member in members
            for candidate in (member, *member.actions.values())
            for form in candidate.written
        ),
        payloads=payload_digest(written) if written else "",
    )
    return ClassifiedPart(part, affordances)


def _distinct(texts: Iterable[str]) -> tuple[str, ...]:
    """Return the non-empty *texts*, each once."""
    return tuple(dict.fromkeys(filter(None, texts)))


def _advertised_type(thing: Thing, first: _Candidate | None) -> str:
    """Return the type stated by the first affordance of a part, or else that of the thing."""
    types = [kind for kind in thing.types if kind != "Thing"] if first is None else first.affordance.types
    return next(iter(types), "")


def _lone(candidate: _Candidate) -> str:
    own = LONE_TYPES.get(candidate.capability) or CAPABILITIES[candidate.capability].sensor
    if not own and candidate.affordance.kind == "action":
        return LONE_TYPES["push"]  # it takes a value
    return own or ("x_setting" if candidate.is_settable else "x_sensor")


def _classify(candidate: _Candidate) -> ClassifiedAffordance:
    known, schema = CAPABILITIES[candidate.capability], candidate.affordance.schema
    is_number = known.kind == "number"
    bounds = bounds_of(candidate.capability, candidate.affordance) if is_number else ()
    options: tuple[str, ...] = ()
    if known.kind == "text" and (candidate.capability != "lock" or candidate.service_type):
        options = tuple(text for text in candidate.affordance.schema.enum if isinstance(text, str))
    capability = Capability(
        name=candidate.capability,
        readable=candidate.is_readable,
        settable=candidate.is_settable,
        unit=unit_of(schema) if is_number and not known.unit else "",
        bounds=() if bounds == known.bounds else bounds,
        options=() if options == known.options else options,
    )
    observed = candidate.observed[0] if candidate.is_readable else None
    written = candidate.written[0] if candidate.is_written else None
    actions = {value: _classify(action) for value, action in candidate.actions.items()}
    return ClassifiedAffordance(capability, candidate.affordance, observed, written, actions)
