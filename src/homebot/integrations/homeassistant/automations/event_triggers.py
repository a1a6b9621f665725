"""Triggers by messages, events and presses. Pure.

Source: Home Assistant core 2026.11, ``components/mqtt/device_trigger.py``, ``components/zha``, ``components/hue``.
"""

from typing import Final

from homebot.devices.capabilities import EVENTS
from homebot.devices.device import Device
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import (
    Automation,
    StartTrigger,
    text_value,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.words.steps import MAX_LINES
from homebot.words.triggers import MessageComes, Press, button_names, read_trigger


def message_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
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
    return [StartTrigger(press_text(name, press), data=(("payload", press),)) for press in presses]


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
            return press_text(automation.entities.name_of(device), payload)
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


ADVICE: Final = {
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
"""The text to write instead of a trigger, by its kind or event."""

_SENDERS: Final = {
    "zha_event": ("device_ieee", "command"),
    "deconz_event": ("unique_id", "event"),
    "hue_event": ("unique_id", "type"),
}
"""The fields of events with the address of the device and its event."""


def event_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the events of a device: the given one, else each that it has."""
    kind, data = fields.text("event_type"), fields.inner("event_data")
    if kind == "timer.finished":
        entity = automation.entities.find(data.text("entity_id"))
        data.end()
        return [StartTrigger(press_text(entity.name, "finished"))]
    if kind in {"homeassistant_started", "homeassistant_start"}:
        data.end()
        return [StartTrigger("homebot starts")]
    if kind not in _SENDERS:
        raise NotCarriedError(
            f"trigger event: {kind!r}{ADVICE.get(kind, '')}; carried over are events of {', '.join(_SENDERS)}"
        )
    address_field, command_field = _SENDERS[kind]
    address, command, subtype = (data.text(key, "") for key in (address_field, command_field, "subtype"))
    device_id, slug = data.text("device_id", ""), data.text("id", "")
    data.take("endpoint_id")
    for key in ("args", "params"):  # of an event that its command tells already they are empty
        if (node := data.left.get(key)) is not None and node.value in ([], {}, None):
            data.take(key)
    if given := data.first_of(("args", "params")):
        raise NotCarriedError(
            f"trigger event: `{given}` of {kind}: homebot tells its command alone; bind the button itself, "
            "see `homebot bind` in docs/routines.md"
        )
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
    return [StartTrigger(press_text(name, event), data=((command_field, command or event),)) for event in events]


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


def options_of(device: Device) -> set[str]:
    """Return the events that *device* tells of."""
    return {
        option
        for part in device.parts
        for can in part.part.capabilities
        if can.name in EVENTS
        for option in can.options
    }


def device_press(automation: Automation, fields: UnreadFields) -> str:
    """Read the press of a button."""
    kind, subtype, device_id = fields.text("type"), fields.text("subtype", ""), fields.text("device_id")
    for key in ("domain", "discovery_id"):
        fields.take(key)
    device = automation.entities.device_of(device_id)
    known = {option for part in device.parts for can in part.part.capabilities for option in can.options}
    for press in (subtype if kind == "action" else "", f"{kind} {subtype}".strip()):
        if press in known:
            return press_text(automation.entities.name_of(device), press)
    raise NotCarriedError(f"trigger device: {device.name} has no event {kind} {subtype}")


def press_text(name: str, event: str) -> str:
    """Return the trigger that a device tells *event*; any event if it is empty."""
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
