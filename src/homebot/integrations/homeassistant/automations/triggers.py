"""Triggers of automations as triggers of routines. Pure.

Source: Home Assistant core 2026.11, ``components/homeassistant/triggers``, ``components/sun/trigger.py``,
``components/zone/trigger.py``, ``components/mqtt/device_trigger.py``.
"""

from typing import Final

from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.states import STATES, state_texts, sun_moment
from homebot.words.triggers import Press, read_trigger

_OPPOSITES: Final = {
    "on": "off",
    "off": "on",
    "above_horizon": "below_horizon",
    "below_horizon": "above_horizon",
}
"""States with one other state, beside unknown ones."""

_OF_TWO_STATES: Final = {"binary_sensor", "fan", "humidifier", "input_boolean", "light", "siren", "sun", "switch"}


def read_triggers(automation: Automation, fields: UnreadFields) -> list[str]:
    """Return the triggers of *fields*, each of which starts the routine."""
    kind = fields.text("trigger", "") or fields.text("platform", "")
    fields.take("id")
    match kind:
        case "time":
            days = fields.days()
            times = [f"{time} {days}".rstrip() for time in fields.clock_times("at")]
            if not times:
                raise NotCarriedError("trigger time: `at` is missing")
            return times
        case "sun":
            return [sun_moment(fields, fields.text("event"), "offset")]
        case "device" if "entity_id" not in fields:
            return [_device_press(automation, fields)]
        case "state":
            return _state(automation, fields)
        case kind if kind in STATES:
            leaves = kind == "zone" and fields.text("event", "enter") == "leave"
            lasting = _lasting(fields)
            texts = [text for entity_texts in STATES[kind](automation.entities, fields, "to") for text in entity_texts]
            return [f"{text.replace('place=', 'place!=') if leaves else text}{lasting}" for text in texts]
        case "":
            fields.end()
    raise NotCarriedError(f"trigger: {kind!r} has no counterpart in routines")


def _state(automation: Automation, fields: UnreadFields) -> list[str]:
    ids, states, before = fields.texts("entity_id"), fields.texts("to"), fields.texts("from")
    if not ids:
        raise NotCarriedError("trigger state: `entity_id` is missing")
    automation.starts.append((frozenset(ids), frozenset(states)))
    are_two = _OF_TWO_STATES.issuperset(entity_id.partition(".")[0] for entity_id in ids)
    if before and not (are_two and [_OPPOSITES.get(state, "") for state in states] == before):
        raise NotCarriedError(f"trigger state: `from` {', '.join(before)}; routines know only the new state")
    lasting, attribute = _lasting(fields), fields.text("attribute", "")
    triggers = []
    for entity_id in ids:
        entity = None if lasting or before or entity_id == "sun.sun" else automation.entities.find(entity_id)
        if entity is not None and entity.has("press"):
            triggers += _presses(entity, states, attribute)
        elif attribute:
            raise NotCarriedError(f"trigger state: the attribute {attribute!r}")
        else:
            triggers += [f"{text}{lasting}" for text in state_texts(automation.entities, entity_id, states, "to")]
    return triggers


def _device_press(automation: Automation, fields: UnreadFields) -> str:
    """Read the press of a button."""
    kind, subtype, device_id = fields.text("type"), fields.text("subtype", ""), fields.text("device_id")
    for key in ("domain", "discovery_id"):
        fields.take(key)
    device = automation.entities.device_of(device_id)
    known = {option for part in device.parts for can in part.part.capabilities for option in can.options}
    for press in (subtype if kind == "action" else "", f"{kind} {subtype}".strip()):
        if press in known:
            return _press(automation.entities.name_of(device), press)
    raise NotCarriedError(f"trigger device: {device.name} has no event {kind} {subtype}")


def _presses(entity: KnownEntity, states: list[str], attribute: str) -> list[str]:
    """Return the presses of an entity of events: its state is a time, and that of a sensor is the event itself."""
    is_event_itself = entity.domain == "sensor" and not attribute
    if states and (is_event_itself or attribute == "event_type"):
        return [_press(entity.name, state) for state in states]
    if entity.domain == "event" and not states and not attribute:
        return [_press(entity.name, "")]
    raise NotCarriedError(f"trigger state: {entity.id} has only the attribute event_type")


def _press(name: str, event: str) -> str:
    value = event if not event or event.replace("_", "").isalnum() else text_value(event)
    text = f"name={text_value(name)} press {value}".rstrip()
    try:
        trigger = read_trigger(text)
    except UsageError:
        trigger = None
    if not isinstance(trigger, Press) or trigger.value != event.casefold():
        raise NotCarriedError(f"the event {event!r} of {name} cannot be written as a trigger")
    return text


def _lasting(fields: UnreadFields) -> str:
    return f" for {length}" if (length := fields.duration("for")) else ""
