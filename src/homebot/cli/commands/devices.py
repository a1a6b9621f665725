"""``homebot devices``."""

from __future__ import annotations

import argparse
import json
import sys

from homebot.cli.device_json import device_json
from homebot.cli.device_queries import all_devices, house_time
from homebot.cli.door_client import DoorClient
from homebot.cli.terminal import print_table
from homebot.cli.thing_files import write_things
from homebot.cli.time_format import ago
from homebot.cli.values import life, main_parts, state_text, types
from homebot.cli.with_client import with_client
from homebot.devices import Device
from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.names import read_text_address
from homebot.devices.query import type_is
from homebot.devices.query.vocabulary import TYPE_WORDS
from homebot.similar import did_you_mean

__all__ = ["list_devices"]

_HEAD = ("DEVICE", "TYPE", "AREA", "STATE", "GATEWAY", "COMMAND TOPIC", "AVAILABILITY", "LAST SEEN")
_IF_ANY = ("AREA", "STATE", "COMMAND TOPIC")
_IF_ROOM = ("GATEWAY", "COMMAND TOPIC")
_WRONG_COMMAND_LINE = 2


def list_devices(options: argparse.Namespace) -> int:
    """Print the devices as a table or as a JSON list, or write their Thing Descriptions."""
    found: list[Device] = []

    async def run(door: DoorClient) -> int:
        devices = await all_devices(door, options.type)
        if options.type and not devices and (problem := await _unknown_type(door, options.type)):
            print(f"homebot: {problem}", file=sys.stderr)
            return _WRONG_COMMAND_LINE
        if options.td:
            found.extend(devices)
        elif options.json:
            print(json.dumps([device_json(one) for one in devices], indent=2))
        elif not devices:
            print(f"no device offers {options.type} now" if options.type else "no device discovered yet")
        else:
            now = await house_time(door)
            rows = [_row(one, now) for one in devices]
            print_table(_HEAD, rows, if_any=_IF_ANY, if_room=_IF_ROOM, in_colour="AVAILABILITY")
        return 0

    code = with_client(options, run)
    for file in write_things(found, options.td, options.broker) if options.td else ():
        print(file)
    return code


def _row(device: Device, now: float) -> tuple[str, ...]:
    first = device.endpoints[0] if device.endpoints else None
    return (
        device.id,
        types(device),
        device.area,
        state_text(device),
        first.gateway if first else "",
        _command_topic(device),
        life(device),
        ago(device.last_seen, now),
    )


async def _unknown_type(door: DoorClient, name: str) -> str:
    """Return why there cannot be devices of the type *word*; empty where there only happen to be none."""
    if wanted_types(name) or name in DEVICE_TYPES or type_is(name).types:
        return ""
    own = {one for device in await all_devices(door) for one in (device.service_type, *device.service_types) if one}
    return f"{name!r} is not a device type, and no device was announced as one; " + did_you_mean(
        name, {*TYPE_WORDS, *own}, "`homebot devices` shows the type of each device"
    )


def _command_topic(device: Device) -> str:
    """Return the address on which a device takes commands; empty where it takes none.

    Words have an address of their own, which says nothing to people.
    """
    for one in device.endpoints:
        if one.command_address and read_text_address(one.command_address) is None:
            return one.command_address
    return next((topic for part in main_parts(device) for topic in part.part.writes), "")
