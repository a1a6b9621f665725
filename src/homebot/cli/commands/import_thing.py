"""Things in files: ``homebot import``, and the Thing Descriptions of devices."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import seconds, set_client_command
from homebot.cli.device_queries import all_devices
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.publishing import GatewayPublisher
from homebot.conventions.described_thing import DescribedThing, read_thing, thing_format
from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, parse_json
from homebot.devices import Device
from homebot.devices.names import DEVICE_CHANGES
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.errors import ConfigError, UsageError, WireError
from homebot.messages.json import message_from_json
from homebot.names import escape_token
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import DeviceChange

_EXAMPLES = """\
  homebot import desk_lamp.td.json
  homebot import desk_lamp.td.json --name desk-lamp

The description is published as a retained message on homebot/things/NAME/td; the gateway turns it into a device, which
stays until `homebot forget DEVICE --purge`. MQTT forms with JSON or plain text can be read and written.
"""

_MAX_CHARACTERS = 200


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _import, _EXAMPLES, acts=True)
    parser.add_argument("file", metavar="FILE", help="Thing Description 1.1, as JSON")
    parser.add_argument(
        "--name", metavar="NAME", default="", help="NAME in its topic (default: derived from its id or title)"
    )
    parser.add_argument(
        "--prefix", metavar="P", default="homebot/things", help="first levels of its topic (default: homebot/things)"
    )
    parser.add_argument(
        "--gateway", metavar="G", default="mqtt", help="gateway that is connected to its broker (default: mqtt)"
    )
    parser.add_argument(
        "--timeout", metavar="S", type=seconds, default=5.0, help="seconds to wait for the device (default: 5)"
    )


def _import(options: argparse.Namespace) -> int:
    text, thing = _read(options.file)
    name = topic_level(options.name or thing.id or thing.title)
    topic = f"{options.prefix}/{name}/td"

    def run(door: DoorClient, _: argparse.Namespace) -> int:
        publisher = GatewayPublisher(door)
        publisher.check(options.gateway)
        door.subscribe(DEVICE_CHANGES)
        publisher.publish(options.gateway, topic, text)
        device_id = _wait_for_device(door, options.gateway, f"thing:{name}", options.timeout)
        if device_id:
            print(f"imported {printable(device_id)}, announced on {topic}")
            return 0
        print(
            f"published on {topic}, but no device appeared within {options.timeout:g} s; "
            f"does gateway {options.gateway} understand the convention `thing` there?"
        )
        return 1

    return with_client(options, run)


def topic_level(text: str) -> str:
    """Return *text* as one level of a topic: letters, digits, ``_``, ``.`` and ``-``, at most 100 characters.

    Raises:
        UsageError: Nothing is left of *text*.
    """
    level = re.sub(r"[^A-Za-z0-9_.-]+", "-", text).strip("-")[:100]
    if not level:
        raise UsageError(f"no topic name can be made from {text[:60]!a}; give --name")
    return level


def _read(file: str) -> tuple[str, DescribedThing]:
    try:
        with Path(file).open("rb") as opened:
            payload = opened.read(MAX_ANNOUNCEMENT_BYTES + 1)
    except FileNotFoundError as exc:
        raise ConfigError(file, "", "does not exist") from exc
    except OSError as exc:
        raise ConfigError(file, "", f"cannot be read: {exc.strerror}") from exc
    try:
        value = parse_json(payload, MAX_ANNOUNCEMENT_BYTES, unique=True)
        thing = read_thing(value)
    except WireError as exc:
        if len(payload) <= MAX_ANNOUNCEMENT_BYTES:
            _check_is_json(file, payload)
        raise UsageError(f"{file}: {exc}") from exc
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")), thing


def _check_is_json(file: str, payload: bytes) -> None:
    """Raise an error with the position of invalid JSON in *payload*; the topic's readers check the nesting depth."""
    with suppress(RecursionError):
        try:
            json.loads(payload)
        except json.JSONDecodeError as exc:
            raise ConfigError(file, "", f"is not JSON: {exc.msg} (line {exc.lineno}, column {exc.colno})") from None
        except UnicodeDecodeError:
            raise ConfigError(file, "", "is not JSON: it is not UTF-8 text") from None


def _wait_for_device(door: DoorClient, gateway: str, key: str, timeout: float) -> str:
    """Return the id of the device with the *key* of *gateway*; empty if none appears in time."""
    known = all_devices(door, lambda device: device.id if _is_of(device, gateway, key) else "")
    if any(known):
        return next(filter(None, known))
    for received in door.until(timeout):
        if received.topic == DEVICE_CHANGES:
            change = cast("DeviceChange", JsonMessage(received.message))
            if change.kind != "removed" and _is_of(change.device, gateway, key):
                return change.device.id
    return ""


def _is_of(device: Device, gateway: str, key: str) -> bool:
    ways = [(endpoint.gateway, endpoint.key) for endpoint in device.endpoints]
    ways += [(route.gateway, route.key) for part in device.parts for route in part.routes]
    return (gateway, key) in ways


def to_device(record: Device) -> Device:
    """Return the message that *record* represents."""
    return message_from_json(Device, fields_of(record))


def thing_text(device: Device, broker: str) -> str:
    """Return the Thing Description of *device*; *broker* is the address of its gateways' broker."""
    gateways = {endpoint.gateway for endpoint in device.endpoints}
    gateways |= {route.gateway for part in device.parts for route in part.routes}
    return json.dumps(thing_format().describe(device, dict.fromkeys(gateways, broker)), indent=2)


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
            name = name if len(name) <= _MAX_CHARACTERS else f"{name[:_MAX_CHARACTERS]}_{len(written)}"
            file = Path(directory) / f"{name}.td.json"
            file.write_text(f"{thing_text(device, broker)}\n", encoding="utf-8")
            written.append(file)
    except OSError as exc:
        raise ConfigError("--td", directory, f"cannot be written: {exc.strerror}") from exc
    return written
