"""``homebot devices``."""

from __future__ import annotations

import argparse
import json

from homebot.cli.device_json import device_json
from homebot.cli.door_client import DoorClient
from homebot.cli.inventory import all_devices, house_time
from homebot.cli.moments import ago
from homebot.cli.table import to_table, without_empty
from homebot.cli.thing_files import write_things
from homebot.cli.through_door import through_door
from homebot.cli.values import life, main_parts, says, types
from homebot.devices import Device
from homebot.devices.words import read_words_address

__all__ = ["list_devices"]

_HEAD = ("DEVICE", "TYPE", "AREA", "SAYS", "GATEWAY", "ADDRESS", "STATE", "LAST SEEN")


def list_devices(options: argparse.Namespace) -> int:
    """Print the devices as a table or as a JSON list, or write their Thing Descriptions."""
    found: list[Device] = []

    async def run(door: DoorClient) -> int:
        devices = await all_devices(door, options.type)
        if options.td:
            found.extend(devices)
        elif options.json:
            print(json.dumps([device_json(one) for one in devices], indent=2))
        elif not devices:
            print(f"no device offers {options.type} now" if options.type else "no device was discovered yet")
        else:
            now = await house_time(door)
            print(to_table(*without_empty({"AREA", "SAYS"}, _HEAD, [_row(one, now) for one in devices])))
        return 0

    code = through_door(options, run)
    for file in write_things(found, options.td, options.broker) if options.td else ():
        print(file)
    return code


def _row(device: Device, now: float) -> tuple[str, ...]:
    first = device.endpoints[0] if device.endpoints else None
    return (
        device.id,
        types(device),
        device.area,
        says(device),
        first.gateway if first else "",
        _address(device),
        life(device),
        ago(device.last_seen, now),
    )


def _address(device: Device) -> str:
    """Where it speaks, or at least listens; words have an address of their own, which says nothing to people."""
    for one in device.endpoints:
        if one.address and read_words_address(one.address) is None:
            return one.address
    topics = [topic for part in main_parts(device) for topic in (*part.part.reads, *part.part.writes)]
    return topics[0] if topics else ""
