"""Triggers by the states of entities. Pure."""

from collections.abc import Iterator, Sequence
from datetime import timedelta
from typing import Final, NamedTuple

from homebot.devices.capabilities import EVENTS
from homebot.integrations.homeassistant.automations.entities import (
    Automation,
    KnownEntity,
    StartTrigger,
    is_of_device,
    text_value,
)
from homebot.integrations.homeassistant.automations.event_triggers import press_text
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.states import (
    UNKNOWN,
    attribute_text,
    number_of,
    state_texts,
    state_value,
)
from homebot.integrations.homeassistant.automations.template_calculations import step_length
from homebot.integrations.homeassistant.automations.templates import bracketed
from homebot.support.folding import fold
from homebot.units import parse_duration
from homebot.words.triggers import Changes, button_names, read_trigger

_OPPOSITES: Final = {
    "on": "off",
    "off": "on",
    "above_horizon": "below_horizon",
    "below_horizon": "above_horizon",
    "home": "not_home",
    "not_home": "home",
}
"""States with one other state, beside unknown ones."""

_OF_TWO_STATES: Final = frozenset(
    {"binary_sensor", "fan", "group", "humidifier", "input_boolean", "light", "schedule", "siren", "sun", "switch"}
)


def moved(text: str, lasting: str, *, is_leave: bool) -> str:
    """Return the trigger of a state that lasts, or that ends if *is_leave*."""
    if text.endswith(" arrives") and is_leave:
        text = f"{text.removesuffix(' arrives')} leaves"
    if lasting and text.endswith((" arrives", " leaves", "body is home")):
        if text.endswith("leaves"):
            return f"{text.removesuffix(' leaves')} is away{lasting}"
        if text != "nobody is home":
            raise NotCarriedError("`for` of an arrival; write it as a step, `wait`, with a condition after it")
    return f"{text.replace('place=', 'place!=') if is_leave else text}{lasting}"


_OF_STATE: Final = frozenset({"to", "not_to", "not_from"})
"""The fields with which a change of attributes alone starts nothing."""


class _AskedState(NamedTuple):
    """The states of its entities that a trigger asks for.

    Attributes:
        has_states: Whether it names the states, perhaps as any: ``to:``.
    """

    states: list[str]
    before: list[str]
    has_states: bool
    attribute: str
    lasting: str


def state_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers of ``state``, for each of its entities."""
    ids, has_states, attribute = (
        fields.texts("entity_id"),
        not fields.left.keys().isdisjoint(_OF_STATE),
        fields.text("attribute", ""),
    )
    asked = _AskedState(
        fields.texts("to"), fields.texts("from"), has_states, attribute, lasting_text(automation, fields)
    )
    for key in ("not_to", "not_from"):
        if others := {*fields.texts(key)} - UNKNOWN:
            if key == "not_to" and len(others) == 1 and len(ids) == 1 and not (asked.states or asked.before):
                return [_left(automation, ids[0], min(others), asked)]
            raise NotCarriedError(f"trigger state: `{key}` {min(others)}; name the states with `to`")
    if not ids:
        raise NotCarriedError("trigger state: `entity_id` is missing")
    return [
        trigger._replace(data=(*trigger.data, *_facts_of(trigger, asked)))
        for entity_id in ids
        for trigger in _state_of(automation, entity_id, asked)
    ]


def _facts_of(trigger: StartTrigger, asked: _AskedState) -> Iterator[tuple[str, str]]:
    """Yield the state before and the length of a trigger, as far as these are known."""
    yield from length_facts(asked.lasting)
    if len(asked.before) == 1:
        yield "from", asked.before[0]
    elif trigger.entity.partition(".")[0] in _OF_TWO_STATES and trigger.state in _OPPOSITES:
        yield "from", _OPPOSITES[trigger.state]


def length_facts(lasting: str) -> Iterator[tuple[str, str]]:
    """Yield the length of a trigger as Home Assistant writes it, if it is known."""
    if lasting and "{" not in lasting:
        yield "for", str(timedelta(seconds=parse_duration(lasting.removeprefix(" for "))))


def _state_of(automation: Automation, entity_id: str, asked: _AskedState) -> list[StartTrigger]:
    """Return the triggers for the states of an entity."""
    domain = entity_id.partition(".")[0]
    if automation.entities.is_household(entity_id, by_name=True) and not (asked.states or asked.before):
        asked = asked._replace(states=["home", "not_home"])
    if domain in _OF_TWO_STATES:
        asked = _of_two_states(asked)
    if members := automation.entities.members(entity_id):
        return [*_of_group(automation, entity_id, members, asked)]
    if entity_id in {"sun.sun", "zone.home"} or domain == "group":
        return _begun(automation, entity_id, asked)
    entity = automation.entities.find(entity_id)
    asked = _of_moving(entity, asked)
    if (asked.before, asked.states) == (["home"], []) and entity.part.part.service_type == "x_tracker":
        home = state_texts(automation.entities, entity_id, ["home"], "to")[0]
        return [StartTrigger(moved(home, asked.lasting, is_leave=True), entity=entity_id)]
    if entity.has("press") and not asked.lasting and not asked.before:
        return [press._replace(entity=entity_id) for press in _presses(entity, asked.states, asked.attribute)]
    if not asked.states and not asked.before:
        if asked.lasting:
            raise NotCarriedError(f"any change of {entity_id} with `for`; name the state with `to`")
        return [StartTrigger(_change(automation, entity, asked), entity=entity_id)]
    return _begun(automation, entity_id, asked)


def _of_moving(entity: KnownEntity, asked: _AskedState) -> _AskedState:
    """Return *asked* of a person without the place before, and of a person that leaves home with the place after."""
    if entity.part.part.service_type != "x_person":
        return asked
    match asked.before, asked.states:
        case ["home"], [] | ["not_home"]:
            return asked._replace(states=["not_home"], before=[])
        case ["not_home"], ["home"]:
            return asked._replace(before=[])
    return asked


def _of_group(automation: Automation, group: str, members: Sequence[str], asked: _AskedState) -> Iterator[StartTrigger]:
    """Yield the triggers of a group, which is on if any of its members is: of each of these, with the others off."""
    if asked.states not in (["on"], ["off"]) or asked.before or asked.attribute or asked.lasting:
        raise NotCarriedError(f"trigger state: {group} is known to be on or off, without `for`; name its entities")
    (state,) = asked.states
    off = {member: bracketed(state_texts(automation.entities, member, ["off"])[0]) for member in members}
    for member in members:
        (text,) = state_texts(automation.entities, member, [state], "to")
        needs = tuple((text,) for other, text in off.items() if other != member)
        yield StartTrigger(text, entity=group, state=state, needs=needs)


def _left(automation: Automation, entity_id: str, state: str, asked: _AskedState) -> StartTrigger:
    """Return the trigger of an entity that leaves a state for any other one."""
    (text,) = state_texts(automation.entities, entity_id, [state], "to")
    if not is_of_device(text) or asked.attribute:
        raise NotCarriedError(f"trigger state: `not_to` {state}; name the states with `to`")
    return StartTrigger(f"not {text}{asked.lasting}", entity=entity_id)


def _of_two_states(asked: _AskedState) -> _AskedState:
    """Return *asked* without the state before: of two it can only be the other."""
    if len(asked.before) == 1 and not asked.states and not asked.attribute and asked.before[0] in _OPPOSITES:
        asked = asked._replace(states=[_OPPOSITES[asked.before[0]]])
    if asked.states and {*asked.before} == {_OPPOSITES.get(state, "") for state in asked.states}:
        return asked._replace(before=[])
    return asked


def _begun(automation: Automation, entity_id: str, asked: _AskedState) -> list[StartTrigger]:
    """Return the triggers of states, or of the values of an attribute, that begin."""
    if asked.before and asked.states and not asked.attribute:
        return _changes_between(automation.entities.find(entity_id), asked)
    if len(asked.before) == 1 and not asked.states and not asked.attribute:
        return [_left(automation, entity_id, asked.before[0], asked)]
    if asked.before:
        raise NotCarriedError(
            f"trigger state: `from` {', '.join(asked.before)}; routines know only the new state: leave it out, or keep "
            "the state before in a helper"
        )
    if asked.attribute:
        values = [attribute_text(automation.entities, entity_id, asked.attribute, state) for state in asked.states]
        return [StartTrigger(f"{text}{asked.lasting}", entity=entity_id) for text in values]
    texts = state_texts(automation.entities, entity_id, asked.states, "to")
    return [
        StartTrigger(moved(text, asked.lasting, is_leave=False), entity=entity_id, state=state)
        for text, state in zip(texts, asked.states, strict=True)
    ]


def _changes_between(entity: KnownEntity, asked: _AskedState) -> list[StartTrigger]:
    """Return the changes from each state before to each after."""
    changes = [
        _change_between(entity, before, after, asked.lasting) for before in asked.before for after in asked.states
    ]
    texts = [change.text for change in changes]
    return [  # to be idle and to be off is one change, after which a player may be on or off
        change._replace(needs=(), state="") if texts.count(change.text) > 1 else change
        for place, change in enumerate(changes)
        if change.text not in texts[:place]
    ]


def _change_between(entity: KnownEntity, before: str, after: str, lasting: str) -> StartTrigger:
    """Return the change of an entity from one state to another, which may have to last."""
    (capability, first, _), (other, last, needs) = (state_value(entity, state) for state in (before, after))
    if not capability or capability != other or first == last:
        raise NotCarriedError(f"trigger state: `from` {before}: homebot has another word for it; leave it out")
    values = " to ".join(text_value(value) for value in (first, last))
    text = f"{entity.query} {capability.replace('_', ' ')} changes from {values}{lasting}"
    trigger = read_trigger(text)
    if not isinstance(trigger, Changes) or (trigger.before, trigger.after) != (fold(first), fold(last)):
        raise NotCarriedError(f"the change of {entity.id} cannot be written as a trigger")
    held = tuple((bracketed(state),) for state in needs)
    return StartTrigger(text, entity=entity.id, state=after, needs=held)


def _change(automation: Automation, entity: KnownEntity, asked: _AskedState) -> str:
    """Return the change of the state of an entity; of those with attributes any of these may change too."""
    if asked.attribute:
        capability = number_of(automation.entities, entity.id, asked.attribute)[1]
    else:
        is_told = entity.domain in _OF_TWO_STATES | _TOLD_WHOLE
        is_only_state = entity.domain in _PLAIN_DOMAINS or (asked.has_states and is_told)
        own = [name for name in entity.controls[:1] if entity.has(name)] if is_only_state else []
        capability = entity.capability if entity.domain in _SENSOR_DOMAINS else next(iter(own), "")
    if not capability:
        advice = _OF_CHANGES.get(entity.domain, "name the state with `to`")
        raise NotCarriedError(f"any change of {entity.id}; {advice}")
    if entity.domain == "sensor" and not asked.attribute and not asked.has_states:
        automation.notes.append(f"a change of only the attributes of {entity.id} starts nothing")
    text = f"{entity.query} {capability.replace('_', ' ')} changes"
    trigger = read_trigger(text)
    if not isinstance(trigger, Changes) or trigger.capability != capability:
        raise NotCarriedError(f"any change of {entity.id} cannot be written as a trigger")
    return text


_OF_CHANGES: Final = {
    "scene": "start it by what applies the scene",
    "weather": "write `to:`, or name the states",
    **dict.fromkeys(("device_tracker", "person"), "its position changes it too: write `to:`, or name the states"),
}
"""The text to write instead of a trigger by any change, by the domain."""

_SENSOR_DOMAINS: Final = frozenset({"sensor", "binary_sensor"})

_TOLD_WHOLE: Final = frozenset({"alarm_control_panel", "climate", "device_tracker", "lock", "person", "weather"})
"""Domains of which homebot has each state in the same words."""

_PLAIN_DOMAINS: Final = frozenset(
    {"counter", "input_boolean", "input_number", "input_select", "input_text", "number", "select"}
)
"""Domains of entities without an attribute that changes by itself."""


def _presses(entity: KnownEntity, states: list[str], attribute: str) -> list[StartTrigger]:
    """Return the presses of an entity: the state of an event is a time, that of a sensor the event."""
    is_event_itself = entity.domain == "sensor" and not attribute
    buttons = [part for part in entity.device.parts if any(can.name in EVENTS for can in part.part.capabilities)]
    own = dict(zip([part.id for part in buttons], button_names(buttons), strict=True))
    name = f"{entity.name}#{own[entity.part.id]}" if len(buttons) > 1 and entity.part.id in own else entity.name
    if states and (is_event_itself or attribute == "event_type"):
        return [StartTrigger(press_text(name, state), state=state, data=(("event_type", state),)) for state in states]
    if entity.domain in {"event", "input_button"} and not states and not attribute:
        return [StartTrigger(press_text(name, ""), asks="event_type")]
    raise NotCarriedError(f"trigger state: {entity.id} has only the attribute event_type")


def lasting_text(automation: Automation, fields: UnreadFields) -> str:
    """Return the words for the length in ``for``; empty without one."""
    node = fields.left.get("for")
    if node is not None and (length := step_length(automation, node)):
        fields.take("for")
        return f" for {length}"
    return f" for {length}" if (length := fields.duration("for")) else ""
