"""States of entities in the words of routines, as triggers and conditions name them. Pure.

Source: Home Assistant core 2026.11, ``helpers/condition.py``, ``components/homeassistant/triggers``,
``components/zone/trigger.py``, ``components/device_automation``.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Final, TypeAlias

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, NameIs, Operator, StateIs, TypeIs, leaves
from homebot.devices.query.vocabulary import ADJECTIVES
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.routines.triggers import read_state
from homebot.support.folding import fold

__all__ = ["STATES", "SUN", "state_texts"]

_Meaning: TypeAlias = tuple[str, Operator, PlainValue]

_FLAGS: Final = {"on": True, "off": False}
_COVERS: Final[dict[str, _Meaning]] = {"open": ("position", ">", 0.0), "closed": ("position", "=", 0.0)}
_TEXTS: Final = {
    "cover": "movement",
    "lock": "lock",
    "climate": "thermostat_mode",
    "vacuum": "vacuum",
    "alarm_control_panel": "alarm",
    "select": "option",
    "input_select": "option",
    "person": "place",
    "device_tracker": "place",
    "sensor": "value",
    "media_player": "playback",
}
"""The capabilities with the states of domains."""

_PLACES: Final = frozenset({"home", "not_home"})
_PLAYING: Final = frozenset({"playing", "paused"})
_DOMAINS_ON_OFF: Final = frozenset({"light", "switch", "input_boolean", "fan", "siren", "humidifier", "media_player"})
_UNKNOWN: Final = frozenset({"unknown", "unavailable", "none", ""})

SUN: Final = {
    "to": {"above_horizon": "sunrise", "below_horizon": "sunset"},
    "state": {"above_horizon": "sun is up", "below_horizon": "sun is down"},
}
"""The states of ``sun.sun`` as triggers and as conditions."""

_DEVICE: Final = {
    **dict.fromkeys(
        ("turned_on", "is_on", "opened", "is_open", "occupied", "is_occupied", "motion", "is_motion"), "on"
    ),
    **dict.fromkeys(("turned_off", "is_off", "not_opened", "is_not_open", "not_occupied", "is_not_occupied"), "off"),
    **dict.fromkeys(("no_motion", "is_no_motion", "not_moist", "is_not_moist"), "off"),
    **dict.fromkeys(("moist", "is_moist"), "on"),
}
"""The states of triggers and conditions of devices that name an entity, by their types."""


def state_texts(entities: Entities, entity_id: str, states: Sequence[str], key: str = "state") -> list[str]:
    """Return each of *states* of an entity in the words of routines; *key* is the field that names them."""
    if not states:
        raise NotCarriedError(f"any change of {entity_id}; name the state with `{key}`")
    if entity_id == "sun.sun" and SUN[key].keys() >= {*states}:
        return [SUN[key][one] for one in states]
    return [_state_text(entities.find(entity_id), one) for one in states]


def _state_text(entity: KnownEntity, state: str) -> str:
    capability, operator, value = _meaning(entity, state)
    return _text(entity, [StateIs(capability, operator, fold(value) if isinstance(value, str) else value)])


def _of_states(entities: Entities, fields: UnreadFields, key: str) -> list[list[str]]:
    states = fields.texts(key)
    return [state_texts(entities, one, states, key) for one in _ids(fields)]


def _of_limits(entities: Entities, fields: UnreadFields, _key: str) -> list[list[str]]:
    above, below = fields.number("above"), fields.number("below")
    if above is None and below is None:
        raise NotCarriedError("`above` or `below` is missing")
    return [[_limit_text(entities.find(one), above, below)] for one in _ids(fields)]


def _of_zone(entities: Entities, fields: UnreadFields, _key: str) -> list[list[str]]:
    if fields.texts("zone") != ["zone.home"]:
        raise NotCarriedError("zone: homebot knows zone.home alone")
    return [state_texts(entities, one, ["home"]) for one in _ids(fields)]


def _of_device(entities: Entities, fields: UnreadFields, _key: str) -> list[list[str]]:
    kind, _, _ = fields.text("type"), fields.take("domain"), fields.take("device_id")
    if kind not in _DEVICE:
        raise NotCarriedError(f"device: {kind!r} of an entity; use its state")
    return [state_texts(entities, one, [_DEVICE[kind]]) for one in _ids(fields)]


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


def _limit_text(entity: KnownEntity, above: float | None, below: float | None) -> str:
    """Return that the value of an entity is within limits."""
    name = entity.capability
    if entity.domain != "sensor" or CAPABILITIES.get(name, OWN).kind != "number":
        raise NotCarriedError(f"{entity.id} has no limits: homebot reads no number from it")
    if entity.unit:
        own = CAPABILITIES[name].unit
        raise NotCarriedError(f"the limits of {entity.id} are in {entity.unit}, and homebot has it in {own}")
    limits: tuple[tuple[Operator, float | None], ...] = ((">", above), ("<", below))
    return _text(entity, [StateIs(name, operator, limit) for operator, limit in limits if limit is not None])


def _meaning(entity: KnownEntity, state: str) -> _Meaning:
    domain = entity.domain
    if fold(state) in _UNKNOWN:
        raise NotCarriedError(f"{entity.id}: {state!r} is no state that a routine can ask for")
    if domain == "binary_sensor" and state in _FLAGS:
        return entity.capability, "=", _FLAGS[state]
    is_playing_or_idle = domain == "media_player" and state == "on"  # in homebot, what plays is on as well
    if domain in _DOMAINS_ON_OFF and state in _FLAGS and entity.has("on_off") and not is_playing_or_idle:
        return "on_off", "=", _FLAGS[state]
    if domain == "cover" and not entity.has("movement") and state in _COVERS and entity.has("position"):
        return _COVERS[state]
    capability = _TEXTS.get(domain, "")
    if entity.has(capability) and _is_told(entity, capability, state):
        return capability, "=", state
    raise NotCarriedError(f"{entity.id}: homebot knows no state {state!r} of it")


def _is_told(entity: KnownEntity, capability: str, state: str) -> bool:
    """Return whether *state* is one that homebot has in the same words."""
    if capability == "value" and entity.capability != capability:
        return False
    if capability == "playback":
        return state in _PLAYING
    return state in (_PLACES if capability == "place" else entity.options(capability))


def _text(entity: KnownEntity, states: Sequence[StateIs]) -> str:
    """Return the query for *states* of the part, which is read again to be sure of its meaning."""
    kind, capability = entity.part.part.service_type, states[0].capability
    having = [one for one in entity.device.parts if any(can.name == capability for can in one.part.capabilities)]
    if len(having) != 1 and len([one for one in having if one.part.service_type == kind]) != 1:
        raise NotCarriedError(f"{entity.id} is one of several parts of {entity.name}, which cannot be asked alone")
    types = frozenset() if len(having) == 1 else frozenset({kind})
    words = [kind.removeprefix("x_").replace("_", " ")] if types else []
    text = " ".join([*words, f"name={text_value(entity.name)}", *map(_word, states)])
    if not _means(text, entity.name, [replace(one, types=types) for one in states]):
        raise NotCarriedError(f"{entity.id}: the state of {entity.name} cannot be written as a query")
    return text


def _means(text: str, name: str, states: Sequence[StateIs]) -> bool:
    """Return whether routines read *text* as these *states*, also with a length of time after it."""
    try:
        query = parse_query(text)
        lasting = read_state(f"{text} for 1m")
    except UsageError:
        return False
    terms = [one for one in leaves(query) if not isinstance(one, TypeIs)]
    return isinstance(query, And) and terms == [NameIs(fold(name)), *states] and lasting.query == query


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
