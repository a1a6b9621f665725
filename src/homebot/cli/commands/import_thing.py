"""``homebot import``."""

from __future__ import annotations

import argparse
import json
import re
from pathlib import Path

import anyio

from homebot.cli.device_queries import all_devices
from homebot.cli.door_client import DoorClient
from homebot.cli.publishing import GatewayPublisher
from homebot.cli.table import printable
from homebot.cli.with_client import with_client
from homebot.conventions.payload import MAX_ANNOUNCEMENT_BYTES, parse_json
from homebot.devices import DEVICE_CHANGES, Device, DeviceChange
from homebot.errors import ConfigError, UsageError, WireError
from homebot.messages.json import message_from_json
from homebot.wot import Thing, read_thing

__all__ = ["import_thing", "topic_level"]


def import_thing(options: argparse.Namespace) -> int:
    """Check a Thing Description, put it on the broker, and wait until it is a device."""
    text, thing = _read(options.file)
    name = topic_level(options.name or thing.id or thing.title)
    topic = f"{options.prefix}/{name}/td"

    async def run(door: DoorClient) -> int:
        outbox = GatewayPublisher(door)
        await outbox.check(options.gateway)
        await door.subscribe(DEVICE_CHANGES)
        await outbox.publish(options.gateway, topic, text, retain=True)
        with anyio.move_on_after(options.timeout):
            device = await _appeared(door, options.gateway, f"thing:{name}")
            print(f"imported {printable(device.id)}, announced on {topic}")
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
        UsageError: Nothing of it is left.
    """
    level = re.sub(r"[^A-Za-z0-9_.-]+", "-", text).strip("-")[:100]
    if not level:
        raise UsageError(f"no topic name can be made from {text[:60]!a}; give --name")
    return level


def _read(file: str) -> tuple[str, Thing]:
    try:
        with Path(file).open("rb") as opened:
            payload = opened.read(MAX_ANNOUNCEMENT_BYTES + 1)
    except OSError as exc:
        raise ConfigError(file, "", f"cannot be read: {exc.strerror}") from exc
    try:
        value = parse_json(payload, MAX_ANNOUNCEMENT_BYTES, unique=True)
        thing = read_thing(value)
    except WireError as exc:
        raise ConfigError(file, "", str(exc)) from exc
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")), thing


async def _appeared(door: DoorClient, gateway: str, key: str) -> Device:
    for device in await all_devices(door):
        if _is_of(device, gateway, key):
            return device
    while True:
        delivery = await door.next()
        if delivery.topic == DEVICE_CHANGES:
            change = message_from_json(DeviceChange, delivery.message)
            if change.kind != "removed" and _is_of(change.device, gateway, key):
                return change.device


def _is_of(device: Device, gateway: str, key: str) -> bool:
    ways = [(one.gateway, one.key) for one in device.endpoints]
    ways += [(route.gateway, route.key) for part in device.parts for route in part.routes]
    return (gateway, key) in ways
