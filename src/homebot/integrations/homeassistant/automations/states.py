"""States of entities in the words of routines, as triggers and conditions name them. Pure.

Source: Home Assistant core 2026.11, ``helpers/condition.py``, ``components/homeassistant/triggers``,
``components/zone/trigger.py``, ``components/device_automation``.
"""

import re
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

from homebot.devices.capabilities import CAPABILITIES, EVENTS, OWN
from homebot.devices.query.terms import And, NameIs, Operator, StateIs, TypeIs, leaves
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity, slug_of, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.service_tables import SETTINGS
from homebot.support.folding import fold
from homebot.support.numbers import to_number
from homebot.words.message_values import read_comparison
from homebot.words.people import read_move, read_person
from homebot.words.queries import parse_query
from homebot.words.triggers import AtTimeOf, read_state, read_trigger
from homebot.words.vocabulary import ADJECTIVES

_Meaning: TypeAlias = tuple[str, Operator, PlainValue]

_FLAGS: Final = {"on": True, "off": False}
_WITH_NUMBERS: Final = frozenset({"counter", "input_number", "number", "sensor"})
_TIMER: Final = {"active": True, "idle": False}
_COVERS: Final[dict[str, _Meaning]] = {"open": ("position", ">", 0.0), "closed": ("position", "=", 0.0)}
_ALARM: Final = (
    *("disarmed", "armed_home", "armed_away", "armed_night", "armed_vacation"),
    *("arming", "disarming", "pending", "triggered"),
)
_VACUUM: Final = ("cleaning", "docked", "paused", "idle", "returning", "error")
_SAME: Final = {
    "alarm": _ALARM,
    "movement": ("open", "closed", "opening", "closing"),
    "playback": ("playing", "paused"),
    "vacuum": _VACUUM,
}
"""States of capabilities of which others differ, or are not known."""

_SET: Final = {
    "light": ("brightness", "brightness_pct", "color_temp_kelvin", "effect"),
    "climate": ("temperature", "preset_mode", "fan_mode", "swing_mode"),
    "fan": ("percentage", "preset_mode", "direction", "oscillating"),
    "humidifier": ("humidity", "mode"),
    "media_player": ("is_volume_muted", "volume_level", "source"),
    "vacuum": ("fan_speed",),
    "water_heater": ("temperature", "operation_mode"),
}
"""The attributes of entities that services set by fields of the same names."""

_ATTRIBUTES: Final[Mapping[tuple[str, str], tuple[str, float]]] = {
    **{
        (domain, name): (SETTINGS[name].capabilities.split()[0], SETTINGS[name].factor)
        for domain, names in _SET.items()
        for name in names
    },
    ("climate", "current_temperature"): ("local_temperature", 1.0),
    ("climate", "current_humidity"): ("humidity", 1.0),
    ("climate", "hvac_action"): ("thermostat_action", 1.0),
    ("cover", "current_position"): ("position", 1.0),
    ("cover", "current_tilt_position"): ("tilt", 1.0),
    ("climate", "target_humidity"): ("humidity_setpoint", 1.0),
    ("water_heater", "current_temperature"): ("local_temperature", 1.0),
    ("update", "installed_version"): ("version", 1.0),
    ("update", "latest_version"): ("latest_version", 1.0),
    ("vacuum", "battery_level"): ("battery", 1.0),
    ("weather", "temperature"): ("temperature", 1.0),
    ("weather", "humidity"): ("humidity", 1.0),
}
"""The capabilities that attributes of entities are, and the factors of their numbers."""

_ITS_VALUE: Final = re.compile(r"\{\{state\.(?:state|attributes\.(?P<attribute>\w+))(?:\|float(?:\(0\))?)?\}\}")

_LEAST: Final = -1_000_000.0

UNKNOWN: Final = frozenset({"unknown", "unavailable", "none", ""})

SUN: Final = {
    "to": {"above_horizon": "sunrise", "below_horizon": "sunset"},
    "state": {"above_horizon": "sun is up", "below_horizon": "sun is down"},
}
"""The states of ``sun.sun`` as triggers and as conditions."""

_ON: Final = frozenset({"on", "opened", "open", "occupied", "motion", "moist"})
"""The states of triggers and conditions of devices that are ``on``; others are told with ``not`` or ``no``."""


_NAMED_STATES: Final = frozenset(
    {"alarm_control_panel", "cover", "device_tracker", "lock", "media_player", "person", "vacuum"}
)
"""Domains of which triggers and conditions of devices are called as the states are; a cover is ``opened``."""

_HOUSEHOLD: Final = {"home": "somebody is home", "not_home": "nobody is home"}
"""The states of a group of persons."""


def sun_moment(fields: UnreadFields, event: str, key: str) -> str:
    """Return the moment of an *event* of the sun, with the offset in the field *key*."""
    offset = fields.duration(key)
    if event not in {"sunset", "sunrise"}:
        raise NotCarriedError(f"sun: there is no event {event!r}")
    return f"{event} - {offset[1:]}" if offset.startswith("-") else f"{event} + {offset}" if offset else event


def helper_time(entities: Entities, entity_id: str, *told: str) -> str:
    """Return the time of day that a helper tells, in its text or another one of the capabilities *told*."""
    entity = entities.find(entity_id)
    text = f"{next(filter(entity.has, told), 'text')} of {entity.query}"
    if not any(map(entity.has, ("text", *told))) or not isinstance(read_trigger(f"at {text}"), AtTimeOf):
        raise NotCarriedError(f"{entity_id} has no time of day in homebot; write the time itself")
    return text


def state_texts(entities: Entities, entity_id: str, states: Sequence[str], key: str = "state") -> list[str]:
    """Return each of *states* of an entity in the words of routines; *key* is the field that names them."""
    if not states:
        raise NotCarriedError(f"any change of {entity_id}; name the state with `{key}`")
    if entity_id == "sun.sun" and SUN[key].keys() >= {*states}:
        return [SUN[key][state] for state in states]
    if entity_id == "zone.home" and states == ["0"] and entities.knows_people:
        return ["nobody is home"]
    if entities.is_household(entity_id) and _HOUSEHOLD.keys() >= {*states}:
        entities.notes.append(f"{entity_id} is taken as all of [people]")
        return [_HOUSEHOLD[state] for state in states]
    entity = entities.find(entity_id)
    if "not_home" in states and entity.part.part.service_type == "x_person":
        entities.notes.append("`not_home` is anywhere but at home, also in another zone")
    if "unavailable" in states:
        entities.notes.append("`unavailable` is that its device cannot be reached")
    is_either = entity.domain == "media_player" and {"off", "standby"} <= {*states}  # one state of homebot is both
    return [state_text(entity, "off" if is_either and state == "standby" else state, key) for state in states]


def number_of(entities: Entities, entity_id: str, attribute: str) -> tuple[KnownEntity, str, float]:
    """Return the entity, and the capability with the number of its state or attribute, and the factor between them."""
    entity = entities.find(entity_id)
    if not attribute:
        return entity, entity.capability or ("number" if entity.has("number") else ""), 1.0
    capability, factor = _ATTRIBUTES.get((entity.domain, attribute), ("", 1.0))
    if not capability or not entity.has(capability):
        raise NotCarriedError(f"homebot does not read the attribute {attribute!r} of {entity_id}")
    return entity, capability, factor


def value_name(entities: Entities, entity_id: str, attribute: str) -> tuple[str, str]:
    """Return a query for the device of an entity, and the capability that its state or attribute is."""
    entity = entities.find(entity_id)
    capability = number_of(entities, entity_id, attribute)[1] if attribute else entity.capability
    capability = capability or next((name for name in entity.controls if entity.has(name)), "")
    if not capability or entity.unit:
        raise NotCarriedError(f"{entity_id} has no value for a message, or has it in another unit")
    return entity.query, capability


def values_text(
    entities: Entities, first: tuple[str, str], sign: str, second: tuple[str, str], offset: float = 0.0
) -> str:
    """Return the condition that the value of one entity, or its attribute, is above or below that of another."""
    texts: list[str] = []
    for entity_id, attribute in (first, second):
        entity, capability, factor = number_of(entities, entity_id, attribute)
        if CAPABILITIES.get(capability, OWN).kind != "number" or factor != 1.0 or entity.unit:
            raise NotCarriedError(f"{entity_id} has no number in the unit of homebot that can be compared with another")
        texts.append(f"{capability} of {entity.query}")
    more = f" {'plus' if offset > 0 else 'minus'} {abs(offset):.12g}" if offset else ""
    text = f"{texts[0]} {'above' if sign == '>' else 'below'} {texts[1]}{more}"
    if read_comparison(text) is None:
        raise NotCarriedError(f"{text!r} cannot be written as a condition")
    return text


def attribute_of(entities: Entities, entity_id: str, attribute: str, value: object) -> str:
    """Return the condition that an attribute of an entity has a value."""
    entity, capability, factor = number_of(entities, entity_id, attribute)
    if isinstance(value, bool) and CAPABILITIES.get(capability, OWN).kind == "bool":
        return f"({_text(entity, [StateIs(capability, '=', value)])})"
    if isinstance(value, str) and factor == 1.0 and value in entity.options(capability):
        return f"({_text(entity, [StateIs(capability, '=', fold(value))])})"
    if type(value) in (int, float) and factor == 1.0:
        return f"({limits_text(entity, capability, [('=', float(str(value)))])})"
    raise NotCarriedError(f"the attribute {attribute!r} of {entity_id} is compared with {value!r}")


def known_texts(entities: Entities, entity_id: str) -> tuple[str, ...]:
    """Return the texts of the condition that the state of an entity is known: a number, or one of two."""
    entity = entities.find(entity_id)
    capability = number_of(entities, entity_id, "")[1] or next(iter(entity.controls), "")
    if CAPABILITIES.get(capability, OWN).kind == "number" and not entity.unit:
        return (f"({limits_text(entity, capability, [('>', _LEAST)])})",)
    if CAPABILITIES.get(capability, OWN).kind == "bool" and entity.has(capability):
        either = (_text(entity, [StateIs(capability, "=", value)]) for value in (True, False))
        return tuple(f"({text})" for text in either)
    raise NotCarriedError(f"whether {entity_id} is known; ask for the states that it must have")


def attribute_text(entities: Entities, entity_id: str, attribute: str, text: str) -> str:
    """Return the state that an attribute of an entity has the value that YAML has as *text*."""
    number = to_number(text)
    value: object = {"true": True, "false": False}.get(text.casefold(), text if number is None else number)
    return attribute_of(entities, entity_id, attribute, value)[1:-1]


def state_text(entity: KnownEntity, state: str, key: str) -> str:
    """Return *state* of an entity in the words of routines; *key* is the field that names it."""
    if entity.part.part.service_type == "x_person":
        return _person_text(entity, state, key)
    if state == "unavailable":
        return f"{entity.query} unreachable"
    meanings = _meanings_of_player(entity, state) or [_meaning(entity, state)]
    return _text(
        entity,
        [StateIs(name, sign, fold(value) if isinstance(value, str) else value) for name, sign, value in meanings],
    )


SUN_ANGLES: Final = frozenset({"elevation", "azimuth"})
"""The attributes of ``sun.sun`` that a routine asks for."""


def sun_angle_text(attribute: str, sign: str, degrees: float) -> str:
    """Return the condition, which is a trigger too, that the sun is above or below so many degrees."""
    return f"sun {attribute} {'above' if sign[0] == '>' else 'below'} {degrees:.12g}°"


def each_state(entities: Entities, entity_id: str) -> list[str]:
    """Return that an entity is in a state, for each state that it may have."""
    entity = entities.find(entity_id)
    name = entity.capability or next(iter(entity.controls), "")
    kind = CAPABILITIES.get(name, OWN).kind
    values: Sequence[PlainValue] = (True, False) if kind == "bool" else [*map(fold, entity.options(name))]
    if not values or not entity.has(name) or kind == "number":
        raise NotCarriedError(f"{entity_id}: how long it has its value; a routine knows that of states alone")
    return [_text(entity, [StateIs(name, "=", value)]) for value in values]


def _of_states(entities: Entities, fields: UnreadFields, key: str) -> list[list[str]]:
    states = fields.texts(key)
    if attribute := fields.text("attribute", ""):
        return [
            [attribute_text(entities, entity_id, attribute, state) for state in states] for entity_id in _ids(fields)
        ]
    return [state_texts(entities, entity_id, states, key) for entity_id in _ids(fields)]


def _person_text(entity: KnownEntity, state: str, key: str) -> str:
    """Return that a person is somewhere, or arrives or leaves if *key* is that of a trigger."""
    words = {"home": ("arrives", "is home"), "not_home": ("leaves", "is away")}
    if state not in words:
        raise NotCarriedError(f"{entity.id}: homebot knows no zone {state!r}, only whether somebody is at home")
    text = f"{entity.name} {words[state][key == 'state']}"
    person = read_move(text) or read_person(text)
    if person is None or NameIs(fold(entity.name)) not in [*leaves(person.query)]:
        raise NotCarriedError(f"{entity.id}: the name {entity.name!r} cannot be written as a person")
    return text


def _of_limits(entities: Entities, fields: UnreadFields, key: str) -> list[list[str]]:
    given: tuple[tuple[Operator, str], ...] = ((">", "above"), ("<", "below"))
    others = [(sign, fields.text(side)) for sign, side in given if _is_entity(fields, side)]
    if others:
        return [
            [values_text(entities, (entity_id, ""), sign, (other, ""))]
            for entity_id in _ids(fields)
            for sign, other in others
        ]
    limits = [(operator, number) for operator, side in given for number in fields.numbers(side)]
    attribute, template = fields.text("attribute", ""), fields.take("value_template")
    if not limits:
        raise NotCarriedError("`above` or `below` is missing")
    if template is not None:
        attribute = _attribute_in(str(template.value))
    ids = _ids(fields)
    if key == "state" and ids == ["sun.sun"] and attribute in SUN_ANGLES:  # a condition holds within both
        return [[_limit_of(entities, "sun.sun", attribute, [limit])] for limit in limits]
    return [[_limit_of(entities, entity_id, attribute, limits)] for entity_id in ids]


def _attribute_in(template: str) -> str:
    """Return the attribute that *template* is; empty for the state."""
    if (value := _ITS_VALUE.fullmatch("".join(template.split()))) is None:
        raise NotCarriedError("value_template: it calculates; routines compare a value itself with a limit")
    return value["attribute"] or ""


def _is_entity(fields: UnreadFields, key: str) -> bool:
    node = fields.left.get(key)
    return node is not None and isinstance(node.value, str) and node.value.partition(".")[0] in _WITH_NUMBERS


def _limit_of(entities: Entities, entity_id: str, attribute: str, limits: Sequence[tuple[Operator, float]]) -> str:
    if entity_id == "sun.sun" and attribute in SUN_ANGLES:
        if len(limits) > 1:
            raise NotCarriedError(f"the {attribute} of the sun between two limits; write a trigger and a condition")
        return sun_angle_text(attribute, *limits[0])
    if entity_id == "zone.home" and entities.knows_people:
        if limits in ([(">", 0.0)], [("<", 1.0)]):
            return "somebody is home" if limits[0][0] == ">" else "nobody is home"
        raise NotCarriedError("zone.home: homebot does not count people; ask for 0 or for any")
    entity, capability, factor = number_of(entities, entity_id, attribute)
    return limits_text(entity, capability, [(operator, limit * factor) for operator, limit in limits])


def _of_zone(entities: Entities, fields: UnreadFields, _key: str) -> list[list[str]]:
    (zone,) = (text.removeprefix("zone.").replace("_", " ") for text in fields.texts("zone")[:1] or ["zone.home"])
    if zone != "home":
        entities.notes.append(f"zone.{slug_of(zone)} is taken as the place {zone!r}, as it is called in Home Assistant")
    return [state_texts(entities, entity_id, [zone]) for entity_id in _ids(fields)]


def _of_device(entities: Entities, fields: UnreadFields, key: str) -> list[list[str]]:
    kind, domain, device_id = fields.text("type"), fields.text("domain", ""), fields.text("device_id", "")
    for entity_id in fields.texts_of("entity_id"):
        entities.find_of_device(entity_id, device_id, domain, kind)
    if "above" in fields or "below" in fields:  # a measurement
        return _of_limits(entities, fields, key)
    word = kind.removeprefix("is_").removeprefix("turned_")
    if domain in _NAMED_STATES:
        word = {"opened": "open"}.get(word, word)
        return [state_texts(entities, entity_id, [word]) for entity_id in _ids(fields)]
    if {word, word.removeprefix("not_"), word.removeprefix("no_")}.isdisjoint(_ON | {"off"}):
        raise NotCarriedError(f"device: {kind!r} of an entity; use its state")
    return [state_texts(entities, entity_id, ["on" if word in _ON else "off"]) for entity_id in _ids(fields)]


STATES: Final[Mapping[str, Callable[[Entities, UnreadFields, str], list[list[str]]]]] = {
    "state": _of_states,
    "numeric_state": _of_limits,
    "zone": _of_zone,
    "device": _of_device,
}
"""Readers of the kinds that triggers and conditions share.

Each returns for each entity the states of which one must be; it is given the name of the field with the states.
"""


def _ids(fields: UnreadFields) -> list[str]:
    if not (ids := fields.texts("entity_id")):
        raise NotCarriedError("`entity_id` is missing")
    return ids


def limits_text(entity: KnownEntity, capability: str, limits: Sequence[tuple[Operator, float]]) -> str:
    """Return that a value of an entity is within limits."""
    own = CAPABILITIES.get(capability, OWN)
    if own.kind != "number" or not entity.has(capability):
        raise NotCarriedError(f"{entity.id} has no limits: homebot reads no number from it")
    if entity.unit:
        raise NotCarriedError(f"the limits of {entity.id} are in {entity.unit}, and homebot has it in {own.unit}")
    return _text(entity, [StateIs(capability, operator, float(f"{limit:.8g}")) for operator, limit in limits])


def _meaning(entity: KnownEntity, state: str) -> _Meaning:
    if fold(state) in UNKNOWN:
        raise NotCarriedError(
            f"{entity.id}: {state!r} is no state that a routine can ask for; homebot tells itself what is unreachable"
        )
    if state in _FLAGS and (flag := _flag_of(entity, state)):
        return flag, "=", _FLAGS[state]
    if entity.domain == "timer" and state in _TIMER:
        return "on_off", "=", _TIMER[state]
    if entity.domain == "cover" and not entity.has("movement") and state in _COVERS and entity.has("position"):
        return _COVERS[state]
    capability = next(iter(entity.controls), "")
    if entity.domain == "sensor" and entity.capability == "value" and not entity.options("value"):
        return "value", "=", state
    if entity.has(capability) and (capability == "place" or state in _told(entity, capability)):
        return capability, "=", state
    raise NotCarriedError(f"{entity.id}: homebot knows no state {state!r} of it")


def _meanings_of_player(entity: KnownEntity, state: str) -> list[_Meaning]:
    """Return the values of a media player that has stopped and is on, or of one that is only stopped; else none."""
    if entity.domain != "media_player" or not entity.has("playback") or state not in {"idle", "standby", "off"}:
        return []
    stopped: _Meaning = ("playback", "=", "stopped")
    if not entity.has("on_off"):
        return [stopped]
    return [stopped, ("on_off", "=", True)] if state == "idle" else []


def state_value(entity: KnownEntity, state: str) -> tuple[str, str, list[str]]:
    """Return the capability that has *state*, its value there, and further states; empty for other states."""
    if entity.domain == "media_player" and state in {"idle", "standby", "off"} and entity.has("playback"):
        also = [StateIs("on_off", "=", state == "idle")] if entity.has("on_off") else []
        return "playback", "stopped", [_text(entity, also)] if also else []
    capability, operator, value = _meaning(entity, state)
    return (capability, state, []) if operator == "=" and value == state else ("", "", [])


def _flag_of(entity: KnownEntity, state: str) -> str:
    """Return the capability that is true or false in *state*, ``on`` or ``off``; empty for none."""
    if entity.domain in {"binary_sensor", "update"}:
        return entity.capability or entity.controls[0]
    is_playing_or_idle = entity.domain == "media_player" and state == "on" and entity.has("playback")
    # in homebot a playing one is on as well
    return "on_off" if "on_off" in entity.controls and entity.has("on_off") and not is_playing_or_idle else ""


def _told(entity: KnownEntity, capability: str) -> Collection[str]:
    """Return the states that homebot has in the same words."""
    is_other = capability in EVENTS or (entity.domain == "sensor" and capability == "value" != entity.capability)
    return () if is_other else _SAME.get(capability) or entity.options(capability)


def _text(entity: KnownEntity, states: Sequence[StateIs]) -> str:
    """Return the query for *states* of the part, which is read again to be sure of its meaning."""
    kind, capability = entity.part.part.service_type, states[0].capability
    having = [part for part in entity.device.parts if any(can.name == capability for can in part.part.capabilities)]
    batteries = [part for part in having if part.part.service_type == "x_battery"]
    is_alone = len(having) == 1 or (capability == "battery" and len(batteries) == 1)  # a main part tells it as well
    if not is_alone and len([part for part in having if part.part.service_type == kind]) != 1:
        raise NotCarriedError(f"{entity.id} is one of several parts of {entity.name}, which cannot be asked alone")
    types = frozenset() if is_alone else frozenset({kind})
    words = [kind.removeprefix("x_").replace("_", " ")] if types else []
    text = " ".join([*words, entity.query, *map(_word, states)])
    if not _means(text, entity.query, [replace(state, types=types) for state in states]):
        raise NotCarriedError(f"{entity.id}: the state of {entity.name} cannot be written as a query")
    return text


def _means(text: str, device: str, states: Sequence[StateIs]) -> bool:
    """Return whether routines read *text* as these *states*, also with a length of time after it."""
    try:
        query = parse_query(text)
        lasting = read_state(f"{text} for 1m")
    except UsageError:
        return False
    terms = [term for term in leaves(query) if not isinstance(term, TypeIs)]
    return isinstance(query, And) and terms == [*leaves(parse_query(device)), *states] and lasting.query == query


def _word(state: StateIs) -> str:
    value = state.value
    if isinstance(value, bool) or state.capability == "lock":
        same = (word for word, meant in ADJECTIVES.items() if meant == (state,))
        if (word := next(same, "")) and " " not in word:
            return word
    shown = (
        str(value).lower()
        if isinstance(value, bool)
        else text_value(value)
        if isinstance(value, str)
        else f"{value:.12g}"
    )
    return f"{state.capability}{state.operator}{shown}"
