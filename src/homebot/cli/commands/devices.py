"""``homebot devices``."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Container
from typing import TYPE_CHECKING, TypeVar

from homebot.cli.arguments import add_broker_option
from homebot.cli.device_json import device_json, json_text, list_text
from homebot.cli.device_queries import all_devices, find_devices, house_time, unapproved
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.remarks import print_error
from homebot.cli.terminal import print_table
from homebot.devices.wording.time_format import ago
from homebot.devices.wording.values import is_topic, life, main_parts, state_text, types
from homebot.errors import PeerError, UsageError
from homebot.support.printable import printable
from homebot.words.tokens import quoted

if TYPE_CHECKING:
    from homebot.devices import Device

T = TypeVar("T")

_HEAD = ("DEVICE", "NAME", "TYPE", "AREA", "STATE", "AVAILABILITY")
_LONG_HEAD = (*_HEAD, "LAST SEEN", "GATEWAY", "COMMAND TOPIC")
_IF_ANY = ("NAME", "AREA", "STATE", "COMMAND TOPIC")
_IF_ROOM = ("GATEWAY", "COMMAND TOPIC", "LAST SEEN", "NAME")
_IF_WIDE = ("TYPE",)
_IF_LONG = ("TYPE", "STATE")
_WIDTH = 100
_WRONG_COMMAND_LINE = 2
_EXAMPLES = """\
  homebot devices
  homebot devices --type lights
  homebot devices --long
  homebot devices --json
  homebot devices --td things/

NAME is left out if it is the same as DEVICE. STATE is the last reported state. AVAILABILITY is `fresh` if the device
reported recently, `unconfirmed` if it is known only from a retained message or the index file, `stale` if it has been
silent for too long, `unreachable` if it or its last will is offline or its gateway lost its connection, and
`partly unreachable` if only some of its parts are. An `unapproved` device is dangerous, and gets no commands before
`homebot approve DEVICE`. COMMAND TOPIC is empty if it takes none.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _devices, _EXAMPLES)
    parser.add_argument("--type", metavar="T", default="", help="only devices of this type, for example lights")
    parser.add_argument(
        "-l", "--long", action="store_true", help="uncut, with the time last seen, gateway and topic for commands"
    )
    parser.add_argument("--td", metavar="DIR", help="write a W3C Thing Description of each device to this directory")
    add_broker_option(parser)
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")


def _devices(door: DoorClient, options: argparse.Namespace) -> int:
    print_all = _write_things if options.td else _print_json if options.json else _print_table
    try:
        print_all(door, options)
    except _UnknownTypeError as exc:
        print_error(str(exc), as_json=options.json)
        return _WRONG_COMMAND_LINE
    return 0


class _UnknownTypeError(UsageError):
    """No device can have the requested type."""


def _print_table(door: DoorClient, options: argparse.Namespace) -> None:
    now = house_time(door)
    waiting = unapproved(door)
    rows = _all(door, options.type, lambda device: _row(device, now, waiting))
    if rows:
        head = _LONG_HEAD if options.long else _HEAD
        print_table(
            head,
            [row[: len(head)] for row in rows],
            if_any=_IF_ANY,
            if_room=_IF_ROOM,
            if_wide=_IF_WIDE,
            in_colour="AVAILABILITY",
            if_long=() if options.long else _IF_LONG,
            width=_WIDTH,
        )
        count = "1 device" if len(rows) == 1 else f"{len(rows):,} devices"
    else:
        count = f"no device offers {options.type} now" if options.type else "no device discovered yet"
    why = "" if rows or options.type else "; `homebot doctor` tells why"
    print(f"{count} in {printable(door.home)}{why}")


def _print_json(door: DoorClient, options: argparse.Namespace) -> None:
    waiting = unapproved(door)
    print(list_text(_all(door, options.type, lambda device: json_text(device_json(device, waiting)))))


def _write_things(door: DoorClient, options: argparse.Namespace) -> None:
    from homebot.cli.commands.import_thing import to_device, write_things  # noqa: PLC0415 - for Thing Descriptions alone

    for file in write_things(_all(door, options.type, to_device), options.td, options.broker):
        print(file)


def _all(door: DoorClient, service_type: str, convert: Callable[[Device], T]) -> list[T]:
    devices = all_devices(door, convert, service_type)
    if service_type and not devices:
        try:
            find_devices(door, f"type={quoted(service_type)}", 1)
        except PeerError as exc:
            raise _UnknownTypeError(str(exc)) from exc
    return devices


def _row(device: Device, now: float, waiting: Container[str]) -> tuple[str, ...]:
    first = device.endpoints[0] if device.endpoints else None
    return (
        device.id,
        "" if device.name == device.id else device.name,
        types(device),
        device.area,
        state_text(device),
        life(device) + (", unapproved" if device.id in waiting else ""),
        ago(device.last_seen, now),
        first.gateway if first else "",
        _command_topic(device),
    )


def _command_topic(device: Device) -> str:
    for endpoint in device.endpoints:
        if is_topic(endpoint.command_address):
            return endpoint.command_address
    return next((topic for part in main_parts(device) for topic in part.part.writes), "")
