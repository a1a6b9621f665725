"""Triggers of automations as triggers of routines. Pure.

Source: Home Assistant core 2026.11, ``components/homeassistant/triggers``, ``components/sun/trigger.py``,
``components/zone/trigger.py``, ``components/mqtt/device_trigger.py``.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Final, NamedTuple, TypeAlias

from homebot.devices.query.parse import parse_query
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Entities, KnownEntity, text_value
from homebot.integrations.homeassistant.automations.fields import (
    NotCarriedError,
    check_keys,
    duration_of,
    fields_of,
    limits_of,
    needed,
    text_of,
    texts_of,
)
from homebot.integrations.homeassistant.automations.states import OPPOSITES, limit_text, state_text
from homebot.integrations.homeassistant.automations.times import clock_time, days_text
from homebot.routines.triggers import Becomes, Press, read_trigger
from homebot.support.located import Located

__all__ = ["StateTrigger", "Triggers"]

_GENERAL: Final = ("platform", "trigger", "id", "alias", "enabled")
_SUN: Final = {"below_horizon": "sunset", "above_horizon": "sunrise"}
_DEVICE: Final = {
    "turned_on": "on", "turned_off": "off", "opened": "on", "not_opened": "off", "occupied": "on",
    "not_occupied": "off", "motion": "on", "no_motion": "off", "moist": "on", "not_moist": "off",
}  # fmt: skip
"""The states of triggers that belong to an entity, by their types."""

_Read: TypeAlias = Callable[[Located, Mapping[str, Located]], list[str]]


class StateTrigger(NamedTuple):
    """The entities of a trigger of a state, and the states that start it."""

    entities: frozenset[str]
    states: frozenset[str]


class Triggers:
    """Reader of the triggers of one automation.

    Attributes:
        states: The triggers of states that were read.
    """

    def __init__(self, entities: Entities) -> None:
        self._entities = entities
        self.states: list[StateTrigger] = []
        self._kinds: Mapping[str, _Read] = {
            "state": self._state,
            "numeric_state": self._numeric,
            "time": self._time,
            "sun": self._sun,
            "zone": self._zone,
            "device": self._device,
        }

    def read(self, node: Located) -> list[str]:
        """Return the triggers of *node*, each of which starts the routine."""
        fields = fields_of(node, "trigger")
        kinds = [fields[one] for one in ("trigger", "platform") if one in fields]
        kind = text_of(kinds[0], "trigger") if kinds else ""
        if kind not in self._kinds:
            raise NotCarriedError(node.line, f"trigger: {kind!r} has no counterpart in routines")
        return self._kinds[kind](node, fields)

    def _state(self, node: Located, fields: Mapping[str, Located]) -> list[str]:
        check_keys(node, "trigger state", *_GENERAL, "entity_id", "to", "from", "for", "attribute")
        ids = texts_of(needed(node, fields, "entity_id"), "entity_id")
        states = texts_of(fields["to"], "to") if "to" in fields else []
        self.states.append(StateTrigger(frozenset(ids), frozenset(states)))
        return [text for one in ids for text in self._of_entity(one, states, node, fields)]

    def _of_entity(
        self, entity_id: str, states: Sequence[str], node: Located, fields: Mapping[str, Located]
    ) -> list[str]:
        is_plain = not {"for", "from", "attribute"} & fields.keys()
        if entity_id == "sun.sun" and is_plain and len(states) == 1 and states[0] in _SUN:
            return [_SUN[states[0]]]
        entity = self._entities.find(entity_id, node.line)
        if entity.has("press") and not {"for", "from"} & fields.keys():
            return _presses(entity, states, node, fields)
        if "attribute" in fields:
            raise NotCarriedError(
                node.line, f"trigger state: the attribute {text_of(fields['attribute'], 'attribute')!r}"
            )
        if not states:
            raise NotCarriedError(node.line, f"trigger state: any change of {entity_id}; name the state with `to`")
        if "from" in fields:
            _check_from(texts_of(fields["from"], "from"), states, fields["from"].line)
        lasting = _lasting(fields)
        return [_checked(state_text(entity, one, node.line), lasting, node.line) for one in states]

    def _numeric(self, node: Located, fields: Mapping[str, Located]) -> list[str]:
        check_keys(node, "trigger numeric_state", *_GENERAL, "entity_id", "above", "below", "for")
        limits, lasting = limits_of(node, fields), _lasting(fields)
        ids = texts_of(needed(node, fields, "entity_id"), "entity_id")
        found = [limit_text(self._entities.find(one, node.line), *limits, node.line) for one in ids]
        return [_checked(one, lasting, node.line) for one in found]

    def _time(self, node: Located, fields: Mapping[str, Located]) -> list[str]:
        check_keys(node, "trigger time", *_GENERAL, "at", "weekday")
        at = needed(node, fields, "at")
        times = at.value if isinstance(at.value, list) else [at]
        days = f" on {days_text(fields['weekday'])}" if "weekday" in fields else ""
        return [f"{clock_time(one, 'at')}{days}" for one in times]

    def _sun(self, node: Located, fields: Mapping[str, Located]) -> list[str]:
        check_keys(node, "trigger sun", *_GENERAL, "event", "offset")
        event = text_of(needed(node, fields, "event"), "event")
        offset = duration_of(fields["offset"], "offset") if "offset" in fields else ""
        if event not in _SUN.values():
            raise NotCarriedError(node.line, f"trigger sun: there is no event {event!r}")
        if offset.strip("-") == "":
            return [event]
        return [f"{event} - {offset[1:]}" if offset.startswith("-") else f"{event} + {offset}"]

    def _zone(self, node: Located, fields: Mapping[str, Located]) -> list[str]:
        check_keys(node, "trigger zone", *_GENERAL, "entity_id", "zone", "event")
        if texts_of(needed(node, fields, "zone"), "zone") != ["zone.home"]:
            raise NotCarriedError(node.line, "trigger zone: homebot knows zone.home alone")
        event = text_of(fields["event"], "event") if "event" in fields else "enter"
        found = []
        for one in texts_of(needed(node, fields, "entity_id"), "entity_id"):
            text = state_text(self._entities.find(one, node.line), "home", node.line)
            found.append(_checked(text if event == "enter" else text.replace("place=", "place!="), "", node.line))
        return found

    def _device(self, node: Located, fields: Mapping[str, Located]) -> list[str]:
        """Read the press of a button, or the state of an entity."""
        check_keys(node, "trigger device", *_GENERAL, *_OF_DEVICE)
        kind = text_of(needed(node, fields, "type"), "type")
        if "entity_id" in fields:
            if kind not in _DEVICE:
                raise NotCarriedError(node.line, f"trigger device: {kind!r} of an entity; use a trigger of its state")
            to = {**fields, "to": Located(_DEVICE[kind], node.line)}
            given = {key: one for key, one in to.items() if key in {"entity_id", "to", "for"}}
            return self._state(Located(given, node.line), given)
        device = self._entities.device_of(text_of(needed(node, fields, "device_id"), "device_id"), node.line)
        subtype = text_of(fields["subtype"], "subtype") if "subtype" in fields else ""
        known = {option for part in device.parts for can in part.part.capabilities for option in can.options}
        for press in (subtype if kind == "action" else "", f"{kind} {subtype}".strip()):
            if press in known and "for" not in fields:
                return [_press(self._entities.name_of(device), press, node.line)]
        raise NotCarriedError(node.line, f"trigger device: {device.name} has no event {kind} {subtype}")


_OF_DEVICE: Final = ("device_id", "domain", "type", "subtype", "discovery_id", "entity_id", "for", "metadata")


def _presses(entity: KnownEntity, states: Sequence[str], node: Located, fields: Mapping[str, Located]) -> list[str]:
    """Return the presses of an entity of events: its state is a time, and that of a sensor is the event itself."""
    if entity.domain == "sensor" and states and "attribute" not in fields:
        return [_press(entity.name, one, node.line) for one in states]
    if entity.domain == "event" and not states and "attribute" not in fields:
        return [_press(entity.name, "", node.line)]
    if not states or "attribute" not in fields or text_of(fields["attribute"], "attribute") != "event_type":
        raise NotCarriedError(node.line, f"trigger state: {entity.id} has only the attribute event_type")
    return [_press(entity.name, one, node.line) for one in states]


def _press(name: str, event: str, line: int) -> str:
    value = event if not event or event.replace("_", "").isalnum() else text_value(event)
    text = f"name={text_value(name)} press {value}".rstrip()
    try:
        found = read_trigger(text)
    except UsageError as exc:
        raise NotCarriedError(line, f"the event {event!r} of {name} cannot be written as a trigger") from exc
    if not isinstance(found, Press) or found.value != event.casefold():
        raise NotCarriedError(line, f"the event {event!r} of {name} cannot be written as a trigger")
    return text


def _lasting(fields: Mapping[str, Located]) -> str:
    if "for" not in fields:
        return ""
    length = duration_of(fields["for"], "for")
    return f" for {length}" if length else ""


def _check_from(before: Sequence[str], states: Sequence[str], line: int) -> None:
    """Check that the new state has only one known other one, which *before* names."""
    if [OPPOSITES.get(one, "") for one in states] != [*before]:
        raise NotCarriedError(line, f"trigger state: `from` {', '.join(before)}; routines know only the new state")


def _checked(state: str, lasting: str, line: int) -> str:
    """Return the trigger *state*, for so long, if homebot reads it in the same way."""
    text = f"{state}{lasting}"
    try:
        found = read_trigger(text)
    except UsageError as exc:
        raise NotCarriedError(line, f"{text!r} cannot be written as a trigger: {exc}") from exc
    if not isinstance(found, Becomes) or found.query != parse_query(state) or bool(found.lasting) != bool(lasting):
        raise NotCarriedError(line, f"{text!r} cannot be written as a trigger")
    return text
