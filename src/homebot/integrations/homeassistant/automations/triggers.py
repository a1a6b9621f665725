"""Triggers of automations as triggers of routines. Pure.

Source: Home Assistant core 2026.11, ``components/homeassistant/triggers``, ``components/sun/trigger.py``,
``components/zone/trigger.py``, ``components/mqtt/device_trigger.py``.
"""

from typing import Final, NamedTuple

from homebot.devices.capabilities import EVENTS
from homebot.devices.device import Device
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.conditions import denied, template_text, templates_of
from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity, StartTrigger, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.states import (
    STATES,
    UNKNOWN,
    attribute_text,
    number_of,
    state_capability,
    state_texts,
    sun_moment,
)
from homebot.integrations.homeassistant.automations.templates import bracketed
from homebot.support.folding import fold
from homebot.support.located import Located
from homebot.words.steps import MAX_LINES
from homebot.words.triggers import AtTimeOf, Changes, MessageComes, Press, button_names, read_trigger

_OPPOSITES: Final = {
    "on": "off",
    "off": "on",
    "above_horizon": "below_horizon",
    "below_horizon": "above_horizon",
    "home": "not_home",
    "not_home": "home",
}
"""States with one other state, beside unknown ones."""

_OF_TWO_STATES: Final = {
    "binary_sensor",
    "fan",
    "group",
    "humidifier",
    "input_boolean",
    "light",
    "siren",
    "sun",
    "switch",
}


def read_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers of *fields*, each of which starts the routine."""
    kind = fields.text("trigger", "") or fields.text("platform", "")
    fields.take("id")
    match kind:
        case "time":
            days = fields.days()
            return [StartTrigger(text) for text in _times(automation, fields, days)]
        case "time_pattern":
            return [*map(StartTrigger, _pattern(automation, fields))]
        case "homeassistant":
            if (event := fields.text("event")) != "start":
                raise NotCarriedError(f"trigger homeassistant: {event!r}; a routine knows only its start")
            return [StartTrigger("homebot starts")]
        case "sun":
            return [StartTrigger(sun_moment(fields, fields.text("event"), "offset"))]
        case "device" if "entity_id" not in fields:
            return [StartTrigger(_device_press(automation, fields))]
        case "mqtt":
            return _messages(automation, fields)
        case "event":
            return _events(automation, fields)
        case "template":
            return _template(automation, fields)
        case "state":
            return _state(automation, fields)
        case kind if kind in STATES:
            is_leave = kind == "zone" and fields.text("event", "enter") == "leave"
            lasting = _lasting(fields)
            ids = fields.texts_of("entity_id")
            limits = tuple((side, str(fields.left[side].value)) for side in ("above", "below") if side in fields)
            if kind == "numeric_state" and (calculated := _calculated(automation, fields)):
                return [
                    StartTrigger(f"{text}{lasting}", entity=entity, data=limits)
                    for entity, text in zip(ids, calculated, strict=True)
                ]
            texts = STATES[kind](automation.entities, fields, "to")
            return [
                StartTrigger(_moved(text, lasting, is_leave=is_leave), entity=entity, data=limits)
                for entity, entity_texts in zip(ids, texts, strict=True)
                for text in entity_texts
            ]
        case "":
            fields.end()
    raise NotCarriedError(f"trigger: {kind!r} has no counterpart in routines{_ADVICE.get(kind, '')}")


def _calculated(automation: Automation, fields: UnreadFields) -> list[str]:
    """Return the difference of two values of each entity, as it passes a limit; none for another value."""
    node = fields.left.get("value_template")
    sides = [side for side in ("above", "below") if side in fields]
    if node is None or "states(" not in str(node.value) or len(sides) != 1:
        return []
    fields.take("value_template")
    (limit,) = fields.numbers(sides[0])
    return [
        templates_of(automation).passed(template_text(node), entity, sides[0], limit)
        for entity in fields.texts("entity_id")
    ]


_ADVICE: Final = {
    "calendar": "; write its days, as in 'on 24 Dec' or '7:00 on mon'",
    "conversation": "; a routine of a button does the same",
    "webhook": "; send a command by HTTP, see docs/http.md",
    "tag": "; start it by a button, or by the tag's reader as a device",
    "tag_scanned": "; start it by a button, or by the tag's reader as a device",
    "mobile_app_notification_action": "; messages have no buttons: start it by a button or helper",
    "ios.action_fired": "; start it by a button or helper",
    "persistent_notification": "; start it by the state that is told of",
    "geo_location": "; homebot knows only who is at home: 'Anna arrives'",
    "sentence": "; a routine of a button does the same",
}


def _times(automation: Automation, fields: UnreadFields, days: str) -> list[str]:
    """Return the times of day of ``at``, of which some may be those of helpers."""
    nodes = fields.items("at")
    entities = [node for node in nodes if "." in str(node.value)]
    given = UnreadFields(Located({"at": Located([node for node in nodes if node not in entities], 0)}, 0), "trigger")
    times = [f"{time} {days}".rstrip() for time in given.clock_times("at")]
    for node in entities:
        if not isinstance(node.value, str):
            raise NotCarriedError("trigger time: `offset` from the time of an entity; write the time itself")
        if days:
            raise NotCarriedError("trigger time: `weekday` with the time of a helper; ask for the days in a condition")
        entity = automation.entities.find(node.value)
        text = f"at text of name={text_value(entity.name)}"
        if not entity.has("text") or not isinstance(read_trigger(text), AtTimeOf):
            raise NotCarriedError(f"trigger time: {entity.id} has no time of day in homebot; write the time itself")
        automation.notes.append(f"{entity.id} starts it each day at its time; one with a date starts nothing")
        times.append(text)
    if not times:
        raise NotCarriedError("trigger time: `at` is missing; write each time as a trigger")
    return times


_MAX_MINUTES: Final = 20
"""Minutes of an hour that are written, each as a trigger."""


def _moved(text: str, lasting: str, *, is_leave: bool) -> str:
    """Return the trigger of a state that lasts, or that ends if *is_leave*."""
    if text.endswith(" arrives") and is_leave:
        text = f"{text.removesuffix(' arrives')} leaves"
    if lasting and text.endswith((" arrives", " leaves", "body is home")):
        if text.endswith("leaves"):
            return f"{text.removesuffix(' leaves')} is away{lasting}"
        if text != "nobody is home":
            raise NotCarriedError("`for` of an arrival; write it as a step, `wait`, with a condition after it")
    return f"{text.replace('place=', 'place!=') if is_leave else text}{lasting}"


def _pattern(automation: Automation, fields: UnreadFields) -> list[str]:
    """Return the times of ``time_pattern``: units below the given one are 0, and those above it any."""
    given = {unit: fields.text(unit, "") for unit in ("hours", "minutes", "seconds")}
    hours, minutes, seconds = given.values()
    if not any(given.values()):
        raise NotCarriedError("trigger time_pattern: `hours`, `minutes` or `seconds` is missing")
    every = (hours or "*", minutes or ("0" if hours else "*"), seconds or "0")
    if every[:2] == ("*", "*") and every[2].startswith("/"):
        automation.notes.append("its seconds are counted from the start of homebot")
        return [f"every {int(every[2][1:])}s"]
    if every[2] not in {"0", "00"}:
        raise NotCarriedError("trigger time_pattern: seconds beside minutes or hours")
    in_hour, in_day = _numbers(every[1], 60), _numbers(every[0], 24)
    if len(in_day) == 24:
        if len(in_hour) <= _MAX_MINUTES:
            return [f"at :{minute:02} every hour" for minute in in_hour]
        automation.notes.append("its minutes are counted from the start of homebot")
        return [f"every {60 // len(in_hour)}m"]
    if len(in_day) * len(in_hour) > MAX_LINES:
        raise NotCarriedError(
            f"trigger time_pattern: more than {MAX_LINES} times a day; ask for the hours in a condition"
        )
    return [f"{hour}:{minute:02}" for hour in in_day for minute in in_hour]


def _numbers(text: str, most: int) -> list[int]:
    """Return the numbers below *most* that ``*``, ``/5`` or ``5`` means."""
    step = text[1:] if text.startswith("/") else "1" if text == "*" else ""
    number = step or text
    if not number.isdecimal() or not int(number) < most or (step and int(number) == 0):
        raise NotCarriedError(f"trigger time_pattern: {text!r}")
    return [*range(0, most, int(step))] if step else [int(number)]


def _template(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the states that must all be for the template to be true, each as a trigger; the others are conditions."""
    node = fields.take("value_template")
    lasting = _lasting(fields)
    conditions = templates_of(automation).conditions(template_text(node))
    texts = [text[1:-1] if text[:1] == "(" else text for condition in conditions for text in condition]
    if len(conditions) == 1 and len(texts) > 1 and not lasting:  # one begins while none of the others is so
        return [
            trigger._replace(needs=tuple(denied([tuple(other for other in conditions[0] if text not in other)])))
            for text in texts
            for trigger in _one_state(text)
        ]
    if any(len(condition) != 1 for condition in conditions) or not texts:
        raise NotCarriedError("trigger template: `or` of several, or with `for`; write each as a trigger")
    if len(texts) == 1 and not lasting:
        return _one_state(texts[0])
    begins = [_one_state(text)[0].text for text in texts]
    if lasting and any(" for " in text or text in _SUN_BEGINS for text in texts):
        raise NotCarriedError("trigger template: `for` of the sun, or of what lasts already; write it without")
    needs = [(bracketed(f"{text}{lasting}"),) for text in texts] if len(texts) > 1 else []
    return [
        StartTrigger(
            f"{begin}{lasting}",
            needs=tuple(need for need, other in zip(needs, texts, strict=False) if not lasting or other != text),
        )
        for begin, text in zip(begins, texts, strict=True)
    ]


def _one_state(text: str) -> list[StartTrigger]:
    """Return the trigger of a state that begins."""
    is_state = "name=" in text and not text.startswith("not ")
    is_person = text.endswith((" is home", " is away"))
    if not is_state and not is_person and not text.startswith("sun elevation ") and text not in _SUN_BEGINS:
        raise NotCarriedError("trigger template: only states start a routine; write the times as triggers")
    return [StartTrigger(_SUN_BEGINS.get(text, text))]


_SUN_BEGINS: Final = {"sun is up": "sunrise", "sun is down": "sunset"}
"""The triggers with which these conditions begin to hold."""


def _messages(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the message, or each press that a topic of actions tells of if no payload is named."""
    topic = fields.texts_of("topic")
    base, _, last = "".join(topic).rpartition("/")
    device = automation.entities.device_at(base) if last == "action" else None
    if device is None or "payload" in fields or "value_template" in fields or not options_of(device):
        payload = "".join(fields.texts_of("payload"))
        return [StartTrigger(_message(automation, fields), data=(("payload", payload),) if payload else ())]
    for key in ("topic", "qos", "encoding"):
        fields.take(key)
    name, presses = automation.entities.name_of(device), sorted(options_of(device))
    if len(presses) > MAX_LINES:
        raise NotCarriedError(f"trigger mqtt: {device.name} has more than {MAX_LINES} actions; name one by `payload`")
    return [StartTrigger(_press(name, press), data=(("payload", press),)) for press in presses]


def _message(automation: Automation, fields: UnreadFields) -> str:
    """Return the press that a message tells of, or the message itself."""
    topic, payload, template = fields.text("topic"), fields.text("payload", ""), fields.take("value_template")
    for key in ("qos", "encoding"):
        fields.take(key)
    path = "".join(str(template.value).split()).strip("{}").replace('"', "'") if template is not None else ""
    path = path.replace("['", ".").replace("']", "")
    base, _, last = topic.rpartition("/")
    for address, is_action in ((base, last == "action" and not path), (topic, path == "value_json.action")):
        device = automation.entities.device_at(address) if is_action and payload else None
        if device is not None and payload in options_of(device):
            return _press(automation.entities.name_of(device), payload)
    root, *places = path.split(".")
    value = payload if payload.isalnum() else text_value(payload)
    value = f"{'.'.join(places)} = {value}" if places else value
    text = f"message on {text_value(topic)}{f' with {value}' if payload else ''}"
    try:
        trigger = read_trigger(text)
    except UsageError:
        trigger = None
    is_path = root == ("value_json" if places else "") and all(place.isidentifier() for place in places)
    wanted = MessageComes(topic, tuple(places), payload) if payload else MessageComes(topic)
    if not is_path or trigger != wanted:
        raise NotCarriedError(f"trigger mqtt: {topic!r} with {path} {payload!r} cannot be written as a trigger")
    automation.notes.append("a retained message, sent before homebot asked, starts nothing")
    return text


_SENDERS: Final = {
    "zha_event": ("device_ieee", "command"),
    "deconz_event": ("unique_id", "event"),
    "hue_event": ("unique_id", "type"),
}
"""The fields of events with the address of the device and its event."""


def _events(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the events of a device: the given one, else each that it has."""
    kind, data = fields.text("event_type"), fields.inner("event_data")
    if kind == "timer.finished":
        entity = automation.entities.find(data.text("entity_id"))
        data.end()
        return [StartTrigger(_press(entity.name, "finished"))]
    if kind not in _SENDERS:
        raise NotCarriedError(
            f"trigger event: {kind!r}{_ADVICE.get(kind, '')}; carried over are events of {', '.join(_SENDERS)}"
        )
    address_field, command_field = _SENDERS[kind]
    address, command, subtype = (data.text(key, "") for key in (address_field, command_field, "subtype"))
    device_id, slug = data.text("device_id", ""), data.text("id", "")
    data.take("endpoint_id")
    data.end()
    known = automation.entities
    if address:
        device = known.device_by_address(address)
    elif device_id:
        device = known.device_of(device_id)
    elif slug:
        device = known.device_called(slug)
    else:
        raise NotCarriedError(f"trigger event: {kind} of any device; name its {address_field}")
    name = automation.entities.name_of(device)
    if kind == "hue_event" and subtype:
        name, device = _button_of(automation, device, subtype)
    options = options_of(device)
    events = [_HUE_PRESSES.get(command, command) if kind == "hue_event" else command] if command else sorted(options)
    if not events or len(events) > MAX_LINES or not options.issuperset(events):
        listed = ", ".join(sorted(options)) or "none"
        raise NotCarriedError(f"trigger event: {device.name} has no event {command!r} in homebot; it has {listed}")
    return [StartTrigger(_press(name, event), data=((command_field, command or event),)) for event in events]


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


def _button_of(automation: Automation, device: Device, number: str) -> tuple[str, Device]:
    """Return the name of a button of *device*, and the device with this button alone."""
    parts = [part for part in device.parts if any(can.name in EVENTS for can in part.part.capabilities)]
    names = [name for part, name in zip(parts, button_names(parts), strict=True) if name.split()[-1:] == [number]]
    if len(parts) == 1 or len(names) != 1:
        raise NotCarriedError(f"trigger event: {device.name} has no button {number} in homebot; name it by its entity")
    of_name = [part for part, name in zip(parts, button_names(parts), strict=True) if name == names[0]]
    return f"{automation.entities.name_of(device)}#{names[0]}", device.model_copy(update={"parts": tuple(of_name)})


_HUE_PRESSES: Final = {"short_release": "single", "double_short_release": "double", "long_press": "long"}
"""Events of Hue buttons in the words of homebot, where these differ."""


def _state(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    ids, has_states, attribute = fields.texts("entity_id"), "to" in fields, fields.text("attribute", "")
    asked = _AskedState(fields.texts("to"), fields.texts("from"), has_states, attribute, _lasting(fields))
    for key in ("not_to", "not_from"):
        if others := {*fields.texts(key)} - UNKNOWN:
            if key == "not_to" and len(others) == 1 and len(ids) == 1 and not (asked.states or asked.before):
                return [_left(automation, ids[0], min(others), asked)]
            raise NotCarriedError(f"trigger state: `{key}` {min(others)}; name the states with `to`")
    if not ids:
        raise NotCarriedError("trigger state: `entity_id` is missing")
    return [trigger for entity_id in ids for trigger in _state_of(automation, entity_id, asked)]


def _state_of(automation: Automation, entity_id: str, asked: _AskedState) -> list[StartTrigger]:
    """Return the triggers for the states of an entity."""
    domain = entity_id.partition(".")[0]
    if domain in _OF_TWO_STATES:
        asked = _of_two_states(asked)
    if entity_id in {"sun.sun", "zone.home"} or domain == "group":
        return _begun(automation, entity_id, asked)
    entity = automation.entities.find(entity_id)
    kind = entity.part.part.service_type
    if asked.before == ["home"] and asked.states in ([], ["not_home"]) and kind in {"x_person", "x_tracker"}:
        if kind == "x_person":
            asked = asked._replace(states=["not_home"], before=[])
        elif not asked.states:
            home = state_texts(automation.entities, entity_id, ["home"], "to")[0]
            return [StartTrigger(_moved(home, asked.lasting, is_leave=True), entity=entity_id)]
    if asked.before == ["not_home"] and asked.states == ["home"] and kind == "x_person":
        asked = asked._replace(before=[])
    if entity.has("press") and not asked.lasting and not asked.before:
        presses = _presses(entity, asked.states, asked.attribute)
        return [StartTrigger(text, entity=entity_id, state=state) for text, state in presses]
    if not asked.states and not asked.before:
        if asked.lasting:
            raise NotCarriedError(f"any change of {entity_id} with `for`; name the state with `to`")
        return [StartTrigger(_change(automation, entity, asked), entity=entity_id)]
    return _begun(automation, entity_id, asked)


def _left(automation: Automation, entity_id: str, state: str, asked: _AskedState) -> StartTrigger:
    """Return the trigger of an entity that leaves a state for any other one."""
    (text,) = state_texts(automation.entities, entity_id, [state], "to")
    if "name=" not in text or asked.attribute:
        raise NotCarriedError(f"trigger state: `not_to` {state}; name the states with `to`")
    return StartTrigger(f"not {text}{asked.lasting}", entity=entity_id)


def _of_two_states(asked: _AskedState) -> _AskedState:
    """Return *asked* without the state before: of two it can only be the other."""
    if len(asked.before) == 1 and not asked.states and not asked.attribute and asked.before[0] in _OPPOSITES:
        asked = asked._replace(states=[_OPPOSITES[asked.before[0]]])
    if asked.before and [_OPPOSITES.get(state, "") for state in asked.states] == asked.before:
        return asked._replace(before=[])
    return asked


def _begun(automation: Automation, entity_id: str, asked: _AskedState) -> list[StartTrigger]:
    """Return the triggers of states, or of the values of an attribute, that begin."""
    if asked.before and asked.states and not asked.attribute and not asked.lasting:
        entity = automation.entities.find(entity_id)
        return [
            StartTrigger(_change_between(entity, before, after), entity=entity_id, state=after)
            for before in asked.before
            for after in asked.states
        ]
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
        StartTrigger(_moved(text, asked.lasting, is_leave=False), entity=entity_id, state=state)
        for text, state in zip(texts, asked.states, strict=True)
    ]


def _change_between(entity: KnownEntity, before: str, after: str) -> str:
    """Return the change of an entity from one state to another, which homebot has in the same words."""
    capability, other = (state_capability(entity, state) for state in (before, after))
    if not capability or capability != other:
        raise NotCarriedError(f"trigger state: `from` {before}: homebot has another word for it; leave it out")
    values = (text_value(value) for value in (before, after))
    text = f"name={text_value(entity.name)} {capability.replace('_', ' ')} changes from {' to '.join(values)}"
    trigger = read_trigger(text)
    if not isinstance(trigger, Changes) or (trigger.before, trigger.after) != (fold(before), fold(after)):
        raise NotCarriedError(f"the change of {entity.id} cannot be written as a trigger")
    return text


def _change(automation: Automation, entity: KnownEntity, asked: _AskedState) -> str:
    """Return the change of the state of an entity; of those with attributes any of these may change too."""
    if asked.attribute:
        capability = number_of(automation.entities, entity.id, asked.attribute)[1]
    else:
        is_only_state = entity.domain in _PLAIN_DOMAINS or (asked.has_states and entity.domain in _OF_TWO_STATES)
        own = [name for name in entity.controls[:1] if entity.has(name)] if is_only_state else []
        capability = entity.capability if entity.domain in _SENSOR_DOMAINS else next(iter(own), "")
    if not capability:
        raise NotCarriedError(f"any change of {entity.id}; name the state with `to`")
    text = f"name={text_value(entity.name)} {capability.replace('_', ' ')} changes"
    trigger = read_trigger(text)
    if not isinstance(trigger, Changes) or trigger.capability != capability:
        raise NotCarriedError(f"any change of {entity.id} cannot be written as a trigger")
    return text


_SENSOR_DOMAINS: Final = frozenset({"sensor", "binary_sensor"})
_PLAIN_DOMAINS: Final = frozenset({"counter", "input_boolean", "input_number", "input_select", "number", "select"})
"""Domains whose entities have no attribute that changes by itself."""


def options_of(device: Device) -> set[str]:
    """Return the events that *device* tells of."""
    return {
        option
        for part in device.parts
        for can in part.part.capabilities
        if can.name in EVENTS
        for option in can.options
    }


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


def _presses(entity: KnownEntity, states: list[str], attribute: str) -> list[tuple[str, str]]:
    """Return the presses of an entity, with its states: that of an event is a time, that of a sensor the event."""
    is_event_itself = entity.domain == "sensor" and not attribute
    if states and (is_event_itself or attribute == "event_type"):
        return [(_press(entity.name, state), state) for state in states]
    if entity.domain == "event" and not states and not attribute:
        return [(_press(entity.name, ""), "")]
    raise NotCarriedError(f"trigger state: {entity.id} has only the attribute event_type")


def _press(name: str, event: str) -> str:
    value = event if not event or event.replace("_", "").isalnum() else text_value(event)
    device, hash_sign, _ = name.partition("#")
    target = text_value(name) if hash_sign else f"name={text_value(device)}"
    text = f"{target} press {value}".rstrip()
    try:
        trigger = read_trigger(text)
    except UsageError:
        trigger = None
    if not isinstance(trigger, Press) or trigger.value != event.casefold():
        raise NotCarriedError(f"the event {event!r} of {name} cannot be written as a trigger")
    return text


def _lasting(fields: UnreadFields) -> str:
    return f" for {length}" if (length := fields.duration("for")) else ""
