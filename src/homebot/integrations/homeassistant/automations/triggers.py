"""Triggers of automations as triggers of routines. Pure.

Source: Home Assistant core 2026.11, ``components/homeassistant/triggers``, ``components/sun/trigger.py``,
``components/zone/trigger.py``, ``components/mqtt/device_trigger.py``.
"""

from typing import Final

from homebot.devices.capabilities import EVENTS
from homebot.devices.device import Device
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.conditions import templates_of
from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity, StartTrigger, text_value
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.states import STATES, UNKNOWN, state_texts, sun_moment
from homebot.words.steps import MAX_LINES
from homebot.words.triggers import Changes, MessageComes, Press, read_trigger

_OPPOSITES: Final = {
    "on": "off",
    "off": "on",
    "above_horizon": "below_horizon",
    "below_horizon": "above_horizon",
}
"""States with one other state, beside unknown ones."""

_OF_TWO_STATES: Final = {"binary_sensor", "fan", "humidifier", "input_boolean", "light", "siren", "sun", "switch"}


def read_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the triggers of *fields*, each of which starts the routine."""
    kind = fields.text("trigger", "") or fields.text("platform", "")
    fields.take("id")
    match kind:
        case "time":
            days = fields.days()
            times = [f"{time} {days}".rstrip() for time in fields.clock_times("at")]
            if not times:
                raise NotCarriedError("trigger time: `at` is missing")
            return [*map(StartTrigger, times)]
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
            return [StartTrigger(_message(automation, fields))]
        case "event":
            return [StartTrigger(_event(automation, fields))]
        case "template":
            return _template(automation, fields)
        case "state":
            return _state(automation, fields)
        case kind if kind in STATES:
            is_leave = kind == "zone" and fields.text("event", "enter") == "leave"
            lasting = _lasting(fields)
            ids = fields.texts_of("entity_id")
            texts = STATES[kind](automation.entities, fields, "to")
            return [
                StartTrigger(_moved(text, lasting, is_leave=is_leave), entity=entity)
                for entity, entity_texts in zip(ids, texts, strict=True)
                for text in entity_texts
            ]
        case "":
            fields.end()
    raise NotCarriedError(f"trigger: {kind!r} has no counterpart in routines{_ADVICE.get(kind, '')}")


_ADVICE: Final = {
    "calendar": "; write its days, as in 'on 24 Dec' or '7:00 on mon'",
    "conversation": "; a routine of a button does the same",
    "webhook": "; send a command by HTTP, see docs/http.md",
}

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
    conditions = templates_of(automation).conditions(str(node.value if node else ""))
    texts = [text[1:-1] if text[:1] == "(" else text for condition in conditions for text in condition]
    if any(len(condition) != 1 for condition in conditions) or not texts:
        raise NotCarriedError("trigger template: `or`; write each as a trigger")
    if any("name=" not in text or text.startswith("not ") for text in texts) or (lasting and len(texts) > 1):
        raise NotCarriedError("trigger template: only states of devices start a routine; write the times as triggers")
    if len(texts) > 1:
        automation.implied += conditions
    return [StartTrigger(f"{text}{lasting}") for text in texts]


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


def _event(automation: Automation, fields: UnreadFields) -> str:
    kind, data = fields.text("event_type"), fields.inner("event_data")
    if kind == "timer.finished":
        entity = automation.entities.find(data.text("entity_id"))
        data.end()
        return _press(entity.name, "finished")
    if kind not in _SENDERS:
        raise NotCarriedError(f"trigger event: {kind!r}; carried over are events of {', '.join(_SENDERS)}")
    address, command = (data.text(key, "") for key in _SENDERS[kind])
    device_id = data.text("device_id", "")
    data.take("endpoint_id")
    data.end()
    if not address and not device_id:
        raise NotCarriedError(f"trigger event: {kind} of any device; name its {_SENDERS[kind][0]}")
    device = automation.entities.device_of(device_id) if device_id else automation.entities.device_by_address(address)
    if command not in options_of(device):
        known = ", ".join(sorted(options_of(device))) or "none"
        raise NotCarriedError(f"trigger event: {device.name} has no event {command!r} in homebot; it has {known}")
    return _press(automation.entities.name_of(device), command)


def _state(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    ids, states, before = fields.texts("entity_id"), fields.texts("to"), fields.texts("from")
    for key in ("not_to", "not_from"):
        if others := {*fields.texts(key)} - UNKNOWN:
            raise NotCarriedError(f"trigger state: `{key}` {min(others)}; name the states with `to`")
    if not ids:
        raise NotCarriedError("trigger state: `entity_id` is missing")
    are_two = _OF_TWO_STATES.issuperset(entity_id.partition(".")[0] for entity_id in ids)
    if before and not states and are_two and len(before) == 1 and before[0] in _OPPOSITES:
        states = [_OPPOSITES[before[0]]]
    lasting, attribute = _lasting(fields), fields.text("attribute", "")
    triggers: list[StartTrigger] = []
    for entity_id in ids:
        entity = None if entity_id in {"sun.sun", "zone.home"} else automation.entities.find(entity_id)
        is_person = entity is not None and entity.part.part.service_type == "x_person"
        goes = before == ["home"] and states in ([], ["not_home"])
        comes = before == ["not_home"] and states == ["home"]
        is_other = before and not (are_two and [_OPPOSITES.get(state, "") for state in states] == before)
        is_leave = before == ["home"] and not states
        if is_other and not (is_person and (goes or comes)) and not is_leave:
            raise NotCarriedError(f"trigger state: `from` {', '.join(before)}; routines know only the new state")
        is_tracker = entity is not None and entity.part.part.service_type == "x_tracker"
        if is_tracker and before == ["home"] and not states:
            home = state_texts(automation.entities, entity_id, ["home"], "to")[0]
            triggers.append(StartTrigger(_moved(home, lasting, is_leave=True), entity=entity_id))
            continue
        wanted = ["not_home"] if is_person and goes else states
        if entity is not None and entity.has("press") and not lasting and not before:
            triggers += [
                StartTrigger(text, entity=entity_id, state=state) for text, state in _presses(entity, states, attribute)
            ]
        elif attribute:
            raise NotCarriedError(f"trigger state: the attribute {attribute!r}")
        elif not wanted and not before and entity is not None:
            triggers.append(StartTrigger(f"{_change(entity)}", entity=entity_id))
            if lasting:
                raise NotCarriedError(f"any change of {entity_id} with `for`; name the state with `to`")
        else:
            texts = state_texts(automation.entities, entity_id, wanted, "to")
            triggers += [
                StartTrigger(_moved(text, lasting, is_leave=False), entity=entity_id, state=state)
                for text, state in zip(texts, wanted, strict=True)
            ]
    return triggers


def _change(entity: KnownEntity) -> str:
    """Return the change of the state of an entity; for those with attributes any of these may change too."""
    if entity.domain not in _SENSOR_DOMAINS or not entity.capability:
        raise NotCarriedError(f"any change of {entity.id}; name the state with `to`")
    text = f"name={text_value(entity.name)} {entity.capability.replace('_', ' ')} changes"
    trigger = read_trigger(text)
    if not isinstance(trigger, Changes) or trigger.capability != entity.capability:
        raise NotCarriedError(f"any change of {entity.id} cannot be written as a trigger")
    return text


_SENSOR_DOMAINS: Final = frozenset({"sensor", "binary_sensor"})


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
