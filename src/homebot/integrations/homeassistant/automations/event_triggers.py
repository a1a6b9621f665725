"""Triggers by messages, events and presses. Pure.

Source: Home Assistant core 2026.11, ``components/mqtt/device_trigger.py``, ``components/zha``, ``components/hue``.
"""

from collections.abc import Sequence
from typing import Final, NamedTuple

from homebot.devices.capabilities import EVENTS
from homebot.devices.device import Device, DevicePart
from homebot.errors import UsageError
from homebot.integrations.homeassistant.automations.entities import (
    Automation,
    KnownEntity,
    StartTrigger,
    slug_of,
    text_value,
)
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.formats.states.presses import APP_EVENTS, APP_KEY, RAW_PART
from homebot.support.folding import fold
from homebot.support.located import Located
from homebot.words.steps import MAX_LINES
from homebot.words.triggers import MessageComes, Press, button_names, read_trigger


def message_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the message, or each press that a topic of actions tells of if no payload is named."""
    topic = fields.texts_of("topic")
    base, _, last = "".join(topic).rpartition("/")
    device = automation.entities.device_at(base) if last == "action" else None
    if device is None or "payload" in fields or "value_template" in fields or not options_of(device):
        payload = "".join(fields.texts_of("payload"))
        text = _message(automation, fields)
        return [StartTrigger(text, data=(("payload", payload),)) if payload else StartTrigger(text, asks="payload")]
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
    text = _message_text(topic, path, payload)
    automation.notes.append("a retained message, sent before homebot asked, starts nothing")
    return text


def _message_text(topic: str, path: str, payload: str) -> str:
    """Return the trigger by a message on *topic* with *payload*, at *path* in its JSON if that is named."""
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
    return text


ADVICE: Final = {
    "calendar": "; write its days, as in 'on 24 Dec' or '7:00 on mon'",
    "conversation": "; a routine of a button does the same",
    "webhook": "; send a command by HTTP, see docs/http.md",
    "call_service": "; start it by what calls the service, or by the state that follows",
    "tag_scanned": "; start it by a button, or by the tag's reader as a device",
    "persistent_notification": "; start it by the state that is told of",
    "geo_location": "; homebot knows only who is at home: 'Anna arrives'",
    "sentence": "; a routine of a button does the same",
}
"""The text to write instead of a trigger, by its kind or event."""


class _Sender(NamedTuple):
    """The fields of events with the address of their device, and with what happened."""

    address: str
    press: str


_SENDERS: Final = {
    "zha_event": _Sender("device_ieee", "command"),
    "deconz_event": _Sender("unique_id", "event"),
    "hue_event": _Sender("unique_id", "type"),
}
_ANSWERS: Final = {"mobile_app_notification_action": "action", "ios.notification_action_fired": "actionName"}
"""The fields of events with the pressed button of a message."""

_STARTS: Final = frozenset({"homeassistant_started", "homeassistant_start"})


class _RemoteButton(NamedTuple):
    """A button of a device.

    Attributes:
        number: Its number on the device; empty if that does not count.
        events: What it tells; None if that is open.
    """

    name: str
    number: str
    events: set[str] | None


def event_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the events of a device: the given one, else each that it has."""
    kind, data = fields.text("event_type"), fields.inner("event_data")
    if kind == "timer.finished":
        entity = automation.entities.find(data.text("entity_id"))
        data.end()
        return [StartTrigger(press_text(entity.name, "finished"))]
    if kind in _STARTS:
        data.end()
        return [StartTrigger("homebot starts")]
    if kind in APP_EVENTS:
        return [_of_app(automation, kind, data)]
    if kind in _ANSWERS:
        action = data.text(_ANSWERS[kind])
        data.end()
        name = message_button(automation, action).name
        return [StartTrigger(press_text(name, ""), data=((_ANSWERS[kind], action),))]
    if kind in _SENDERS:
        return _of_device(automation, kind, data)
    if automation.fires(kind) and not data.left:
        return [StartTrigger(press_text(own_event(automation, kind).name, ""))]
    known = ", ".join((*_SENDERS, *APP_EVENTS))
    raise NotCarriedError(f"trigger event: {kind!r}{ADVICE.get(kind, '')}; carried over are events of {known}")


def message_button(automation: Automation, action: str) -> KnownEntity:
    """Return the helper that stands for a button of messages, which people press on the page."""
    automation.notes.append("buttons of messages are helpers: people press them on the page")
    return automation.entities.find(f"input_button.{slug_of(action)}")


def own_event(automation: Automation, kind: str) -> KnownEntity:
    """Return the helper that stands for an event which automations of the file send each other."""
    return automation.entities.find(f"input_button.{slug_of(kind)}")


def tag_triggers(automation: Automation, fields: UnreadFields) -> list[StartTrigger]:
    """Return the tags that the app of Home Assistant reads."""
    if "device_id" in fields:
        raise NotCarriedError("trigger tag: `device_id`; homebot is not told which phone read it")
    tags = [UnreadFields(Located({"tag_id": Located(tag, 0)}, 0), "tag") for tag in fields.texts("tag_id")]
    return [_of_app(automation, "tag_scanned", tag) for tag in tags]


def _of_app(automation: Automation, kind: str, data: UnreadFields) -> StartTrigger:
    """Return the action of the app of Home Assistant, or the tag that it reads, as its gateway tells it."""
    press = data.text(APP_EVENTS[kind].field)
    data.end()
    try:
        device = automation.entities.device_of(APP_KEY)
    except NotCarriedError:
        raise NotCarriedError(
            f"trigger event: {kind!r}: the gateway of Home Assistant tells it once an app is registered there"
            f"{ADVICE.get(kind, '; start it by a button or helper')}"
        ) from None
    text = press_text(f"{automation.entities.name_of(device)}#{APP_EVENTS[kind].part}", press)
    return StartTrigger(text, data=((APP_EVENTS[kind].field, press),))


def _of_device(automation: Automation, kind: str, data: UnreadFields) -> list[StartTrigger]:
    """Return the events of a button, or of each that its device has."""
    sender, known = _SENDERS[kind], automation.entities
    address, command, subtype = (data.text(key, "") for key in (*sender, "subtype"))
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
    finders = ((address, known.device_by_address), (device_id, known.device_of), (slug, known.device_called))
    device = next((find(text) for text, find in finders if text), None)
    if device is None:
        raise NotCarriedError(f"trigger event: {kind} of any device; name its {sender.address}")
    triggers = [
        trigger
        for button in _buttons(automation, kind, device, subtype)
        for trigger in _presses_of(button, kind, device, command)
    ]
    if len(triggers) > MAX_LINES:
        raise NotCarriedError(f"trigger event: {device.name} has more than {MAX_LINES} events; name one")
    return triggers


def _presses_of(button: _RemoteButton, kind: str, device: Device, command: str) -> list[StartTrigger]:
    """Return the press *command* of *button*, else each that it has, or any if it is not known what it tells."""
    field, events = _SENDERS[kind].press, button.events
    own = (("subtype", button.number),) if button.number else ()
    if events is None:
        told = ((field, command),) if command else ()
        return [StartTrigger(press_text(button.name, command), data=(*told, *own), asks="" if command else field)]
    meant = _HUE_PRESSES.get(command, command) if kind == "hue_event" and command not in events else command
    if not events or (meant and meant not in events):
        listed = ", ".join(sorted(events)) or "none"
        raise NotCarriedError(f"trigger event: {device.name} has no event {command!r} in homebot; it has {listed}")
    return [
        StartTrigger(press_text(button.name, event), data=((field, command or event), *own))
        for event in ([meant] if meant else sorted(events))
    ]


def _buttons(automation: Automation, kind: str, device: Device, number: str) -> list[_RemoteButton]:
    """Return the button *number* of a device of Hue, or all of them; of another device all in one."""
    name = automation.entities.name_of(device)
    parts = [part for part in device.parts if any(can.name in EVENTS for can in part.part.capabilities)]
    if kind != "hue_event" or (len(parts) == 1 and not number):
        is_open = RAW_PART in [part.id for part in parts]
        return [
            _RemoteButton(f"{name}#{RAW_PART}", "", None) if is_open else _RemoteButton(name, "", options_of(device))
        ]
    numbered = [
        _RemoteButton(f"{name}#{button}", button.replace("_", " ").split()[-1], _options(part))
        for part, button in zip(parts, button_names(parts), strict=True)
    ]
    chosen = [button for button in numbered if number in {"", button.number}]
    if not chosen or len(parts) == 1 or len({button.number for button in chosen}) != len(chosen):
        raise NotCarriedError(f"trigger event: {device.name} has no button {number} in homebot; name it by its entity")
    return chosen


def asked_message(trigger: StartTrigger, places: Sequence[str], value: str) -> str:
    """Return the condition that the message of *trigger*, which is any, had *value* at *places* in its JSON.

    Raises:
        NotCarriedError: It cannot be written.
    """
    text = f"{trigger.text} with {'.'.join(places)}{' = ' if places else ''}{text_value(value)}"
    message = read_trigger(text)
    if not isinstance(message, MessageComes) or (message.path, message.value) != (tuple(places), value):
        raise NotCarriedError(f"the message {value!r} cannot be written as a condition")
    return text


def asked_press(trigger: StartTrigger, value: str) -> str:
    """Return the condition that the press of *trigger*, which is any, was *value*.

    Raises:
        NotCarriedError: It cannot be written.
    """
    text = f"{trigger.text} {value if value.isalnum() else text_value(value)}"
    press = read_trigger(text)
    if not isinstance(press, Press) or press.value != value.casefold():
        raise NotCarriedError(f"the event {value!r} cannot be written as a condition")
    return text


_HUE_PRESSES: Final = {"short_release": "single", "double_short_release": "double", "long_press": "long"}
"""Events of Hue buttons in the words of homebot, where these differ."""


def _options(part: DevicePart) -> set[str]:
    return {option for can in part.part.capabilities if can.name in EVENTS for option in can.options}


def options_of(device: Device) -> set[str]:
    """Return the events that *device* tells of."""
    return {option for part in device.parts for option in _options(part)}


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
    device, hash_sign, part = name.partition("#")
    text = f"name={text_value(device)}{hash_sign}{part} press {value}".rstrip()
    try:
        trigger = read_trigger(text)
    except UsageError:
        trigger = None
    if not isinstance(trigger, Press) or (trigger.value, trigger.part) != (event.casefold(), fold(part)):
        raise NotCarriedError(f"the event {event!r} of {name} cannot be written as a trigger")
    return text
