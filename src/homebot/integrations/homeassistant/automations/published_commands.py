"""Messages of MQTT that automations publish, as commands to the devices that they are for. Pure.

Source: https://www.zigbee2mqtt.io/guide/usage/mqtt_topics_and_messages.html#zigbee2mqtt-friendly-name-set, 2026.
"""

import json
from collections.abc import Mapping, Sequence
from itertools import starmap
from typing import Final

from homebot.integrations.homeassistant.automations.entities import Automation, KnownEntity
from homebot.integrations.homeassistant.automations.fields import NotCarriedError, UnreadFields
from homebot.integrations.homeassistant.automations.service_settings import steps_of_entity
from homebot.integrations.homeassistant.automations.service_tables import SERVICE_WORDS, SETTINGS, ServiceSetting

_STATES: Final = {
    "on": "switch.turn_on",
    "off": "switch.turn_off",
    "toggle": "switch.toggle",
    "open": "cover.open_cover",
    "close": "cover.close_cover",
    "stop": "cover.stop_cover",
    "lock": "lock.lock",
    "unlock": "lock.unlock",
}
"""The states of messages, in small letters, with the services whose words mean the same."""

_NUMBERS: Final = {
    "brightness": SETTINGS["brightness"]._replace(factor=100 / 254),
    "position": SETTINGS["position"],
}


def steps_of_message(automation: Automation, data: UnreadFields) -> Sequence[str]:
    """Return the steps for a message to a device that homebot knows."""
    topic, payload = data.text("topic"), data.text("payload")
    for key in ("qos", "retain"):
        data.take(key)
    data.end()
    device = automation.entities.commanded_at(topic)
    fields = _fields(payload)
    settings = [*starmap(_setting, fields.items())]
    if device is None or None in settings or not settings:
        what = "is no device that homebot knows" if device is None else f"{payload!r} is no command that it knows"
        raise NotCarriedError(
            f"mqtt.publish: {topic!r} {what}; command the device itself, or write an app, see docs/apps.md"
        )
    known = [setting for setting in settings if setting is not None]
    wanted = {name for setting in known for name in setting.capabilities.split("|")}
    parts = [
        part for part in device.parts if any(can.name in wanted and can.settable for can in part.part.capabilities)
    ]
    if len(parts) != 1:
        raise NotCarriedError(
            f"mqtt.publish: {device.name} has {len(parts)} parts that take {payload!r}; command the one that is meant"
        )
    entity = KnownEntity(topic, device, parts[0], "", automation.entities.name_of(device))
    automation.entities.used[topic] = entity
    return steps_of_entity("", entity, known, "")


def _fields(payload: str) -> Mapping[str, object]:
    """Return the fields of a message: those of JSON, else its text as the state."""
    try:
        fields = json.loads(payload)
    except (ValueError, RecursionError):
        fields = payload
    return fields if isinstance(fields, dict) else {"state": payload}


def _setting(name: str, value: object) -> ServiceSetting | None:
    """Return the setting of the field *name* of a message; None for another field or value."""
    if name == "state" and (service := _STATES.get(str(value).casefold())) is not None:
        capabilities, _, words = SERVICE_WORDS[service].partition(" ")
        return ServiceSetting(capabilities, words)
    if (row := _NUMBERS.get(name)) is None or not isinstance(value, int | float) or isinstance(value, bool):
        return None
    share = value * row.factor
    return row._replace(value=round(share)) if 0 <= share <= 100 else None
