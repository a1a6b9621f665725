"""States of entities as conditions and triggers of routines. Pure."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, NameIs, Operator, StateIs, TypeIs, leaves
from homebot.devices.query.vocabulary import ADJECTIVES
from homebot.devices.value import PlainValue
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import KnownEntity, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError
from homebot.support.folding import fold

__all__ = ["OPPOSITES", "limit_text", "state_text"]

_SWITCHED: Final[dict[str, tuple[str, Operator, PlainValue]]] = {
    "on": ("on_off", "=", True),
    "off": ("on_off", "=", False),
}
_FLAGS: Final = {"on": True, "off": False}
_COVERS: Final[dict[str, tuple[str, Operator, PlainValue]]] = {
    "open": ("position", ">", 0.0),
    "closed": ("position", "=", 0.0),
}
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
}
_PLAYING: Final = frozenset({"playing", "paused"})
_DOMAINS_ON_OFF: Final = frozenset({"light", "switch", "input_boolean", "fan", "siren", "humidifier", "media_player"})
_UNKNOWN: Final = frozenset({"unknown", "unavailable", "none", ""})

OPPOSITES: Final = {"on": "off", "off": "on"}
"""States with one other state, beside unknown ones."""


def state_text(entity: KnownEntity, state: str, line: int) -> str:
    """Return the state of an entity in the words of routines."""
    capability, operator, value = _meaning(entity, state, line)
    return _text(entity, [StateIs(capability, operator, fold(value) if isinstance(value, str) else value)], line)


def limit_text(entity: KnownEntity, above: float | None, below: float | None, line: int) -> str:
    """Return that the value of an entity is within limits."""
    name = entity.capability
    if entity.domain != "sensor" or CAPABILITIES.get(name, OWN).kind != "number":
        raise NotCarriedError(line, f"{entity.id} has no limits: homebot reads no number from it")
    if entity.unit:
        own = CAPABILITIES[name].unit
        raise NotCarriedError(line, f"the limits of {entity.id} are in {entity.unit}, and homebot has it in {own}")
    limits: tuple[tuple[Operator, float | None], ...] = ((">", above), ("<", below))
    return _text(entity, [StateIs(name, operator, limit) for operator, limit in limits if limit is not None], line)


def _meaning(entity: KnownEntity, state: str, line: int) -> tuple[str, Operator, PlainValue]:
    domain = entity.domain
    if fold(state) in _UNKNOWN:
        raise NotCarriedError(line, f"{entity.id}: {state!r} is no state that a routine can ask for")
    if (switched := _switched(entity, state)) is not None:
        return switched
    if domain == "cover" and not entity.has("movement") and state in _COVERS and entity.has("position"):
        return _COVERS[state]
    if _is_told(entity, capability := _capability(entity, state), state):
        return capability, "=", state
    raise NotCarriedError(line, f"{entity.id}: homebot knows no state {state!r} of it")


def _switched(entity: KnownEntity, state: str) -> tuple[str, Operator, PlainValue] | None:
    """Return the meaning of ``on`` and ``off``, and of the words that stand for them; None if *state* is another."""
    if entity.domain == "binary_sensor" and state in _FLAGS:
        return entity.capability, "=", _FLAGS[state]
    is_playing_or_idle = entity.domain == "media_player" and state == "on"  # in homebot, what plays is on as well
    is_switched = entity.domain in _DOMAINS_ON_OFF and state in _SWITCHED and entity.has("on_off")
    return _SWITCHED[state] if is_switched and not is_playing_or_idle else None


def _capability(entity: KnownEntity, state: str) -> str:
    """Return the capability that tells *state* as a text."""
    plays = entity.domain == "media_player" and state in _PLAYING
    return "playback" if plays and entity.has("playback") else _TEXTS.get(entity.domain, "")


def _is_told(entity: KnownEntity, capability: str, state: str) -> bool:
    if not entity.has(capability):
        return False
    if capability == "value":
        return entity.capability == capability
    is_place = capability == "place" and state in {"home", "not_home"}
    return is_place or state in (entity.options(capability) or CAPABILITIES.get(capability, OWN).options or ())


def _text(entity: KnownEntity, states: Sequence[StateIs], line: int) -> str:
    """Return the query for *states* of the part, which is read again to be sure of its meaning."""
    kind, capability = entity.part.part.service_type, states[0].capability
    having = [one for one in entity.device.parts if any(can.name == capability for can in one.part.capabilities)]
    if len(having) != 1 and len([one for one in having if one.part.service_type == kind]) != 1:
        raise NotCarriedError(
            line, f"{entity.id} is one of several parts of {entity.name}, which cannot be asked alone"
        )
    types = frozenset() if len(having) == 1 else frozenset({kind})
    words = [kind.removeprefix("x_").replace("_", " ")] if types else []
    text = " ".join([*words, f"name={text_value(entity.name)}", *map(_word, states)])
    if not _means(text, entity.name, [replace(one, types=types) for one in states]):
        raise NotCarriedError(line, f"{entity.id}: the state of {entity.name} cannot be written as a query")
    return text


def _means(text: str, name: str, states: Sequence[StateIs]) -> bool:
    try:
        query = parse_query(text)
    except UsageError:
        return False
    terms = [one for one in leaves(query) if not isinstance(one, TypeIs)]
    return isinstance(query, And) and terms == [NameIs(fold(name)), *states]


def _word(state: StateIs) -> str:
    if isinstance(state.value, bool) or state.capability == "lock":
        same = (word for word, meant in ADJECTIVES.items() if meant == (state,))
        if (word := next(same, "")) and " " not in word:
            return word
    value = state.value
    if isinstance(value, bool):
        return f"{state.capability}{state.operator}{str(value).lower()}"
    return f"{state.capability}{state.operator}{text_value(value) if isinstance(value, str) else f'{value:g}'}"
