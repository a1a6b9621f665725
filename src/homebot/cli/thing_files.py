"""Devices as Thing Description files."""

import json
from collections.abc import Iterable
from pathlib import Path

from homebot.devices import Device
from homebot.devices.wording.json_message import fields_of
from homebot.errors import ConfigError
from homebot.messages.json import message_from_json
from homebot.names import escape_token
from homebot.wot.export import MqttForms, to_thing

__all__ = ["thing_text", "to_device", "write_things"]

_LONGEST = 200


def to_device(record: Device) -> Device:
    """Return the message that *record* represents."""
    return message_from_json(Device, fields_of(record))


def thing_text(device: Device, broker: str) -> str:
    """Return the Thing Description of *device*; *broker* is the address of its gateways' broker."""
    gateways = {one.gateway for one in device.endpoints}
    gateways |= {route.gateway for part in device.parts for route in part.routes}
    return json.dumps(to_thing(device, MqttForms(dict.fromkeys(gateways, broker))), indent=2)


def write_things(devices: Iterable[Device], directory: str, broker: str) -> list[Path]:
    """Write a file for each device into *directory*, which is created if necessary; return the files.

    A file is named after the device's id, like a graph topic: ``lights/lamp`` is ``lights_x2flamp.td.json``.

    Raises:
        ConfigError: They cannot be written.
    """
    written: list[Path] = []
    try:
        Path(directory).mkdir(parents=True, exist_ok=True)
        for device in devices:
            name = escape_token(device.id)
            name = name if len(name) <= _LONGEST else f"{name[:_LONGEST]}_{len(written)}"
            file = Path(directory) / f"{name}.td.json"
            file.write_text(f"{thing_text(device, broker)}\n", encoding="utf-8")
            written.append(file)
    except OSError as exc:
        raise ConfigError("--td", directory, f"cannot be written: {exc.strerror}") from exc
    return written
