"""``homebot devices`` and ``homebot find``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Container
from typing import TYPE_CHECKING, TypeVar

from homebot.cli.arguments import add_broker_option, whole
from homebot.cli.device_json import device_json, json_text, list_text
from homebot.cli.device_queries import all_devices, find_devices, house_time, note_near_matches, unapproved, why_none
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import is_terminal, print_table, to_table, without_empty
from homebot.devices.query.tokens import MAX_QUERY, quoted
from homebot.devices.wording.time_format import ago
from homebot.devices.wording.values import is_topic, life, main_parts, state_text, types
from homebot.errors import PeerError, UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.services import QueryDevicesResponse

__all__ = ["add_arguments", "add_find_arguments"]

T = TypeVar("T")

_HEAD = ("DEVICE", "NAME", "TYPE", "AREA", "STATE", "GATEWAY", "COMMAND TOPIC", "AVAILABILITY", "LAST SEEN")
_IF_ANY = ("NAME", "AREA", "STATE", "COMMAND TOPIC")
_IF_ROOM = ("GATEWAY", "COMMAND TOPIC")
_IF_WIDE = ("LAST SEEN", "TYPE", "NAME")
_WRONG_COMMAND_LINE = 2
_EXAMPLES = """\
  homebot devices
  homebot devices --type lights
  homebot devices --json
  homebot devices --td things/

NAME is left out if it is the same as DEVICE. STATE is the last reported state. COMMAND TOPIC is the topic for commands,
empty if it takes none; send one with
`homebot topic pub --once /gateway/mqtt/out '{address: home/lights/lamp/in, payload: off}'`. AVAILABILITY is `fresh`
if the device reported recently, `unconfirmed` if it is known only from a retained message or the index file, `stale`
if it has been silent for too long, `unreachable` if it or its last will is offline or its gateway lost its connection,
and `partly unreachable` if only some of its parts are. An `unapproved` device is dangerous, and gets no commands before
`homebot approve DEVICE`.
"""

_FIND_HEAD = ("DEVICE", "NAME", "TYPE", "AREA", "STATE", "AVAILABILITY")
_FIND_IF_ANY = ("AREA", "STATE")
_WIDEST = 300


_FIND_EXAMPLES = """\
  homebot find 'light and dimmable in kitchen'
  homebot find on lights
  homebot find --why window
  homebot find 'off light near robot'
  homebot find 'lamps within 5 m of robot'
  homebot find 'sensor with temperature not stale'

A query combines types (light, lamp, window, …), capabilities (dimmable, temperature > 21), states (on, open, locked),
rooms and floors (`in AREA`, `without area`), robots (`near ROBOT`: shortest way first), tags (tag=night),
problems (stale, unreachable, disputed), missing approvals (unapproved), settings (category=config) and words from
names and models, with `and`, `or`, `not` and parentheses.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _devices, _EXAMPLES)
    parser.add_argument("--type", metavar="T", default="", help="only devices of this type, for example lights")
    parser.add_argument("--td", metavar="DIR", help="write a W3C Thing Description of each device to this directory")
    add_broker_option(parser)
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")


def _devices(door: DoorClient, options: argparse.Namespace) -> int:
    print_all = _write_things if options.td else _print_json if options.json else _print_table
    try:
        print_all(door, options)
    except _UnknownTypeError as exc:
        print(f"homebot: {exc}", file=sys.stderr)
        return _WRONG_COMMAND_LINE
    return 0


class _UnknownTypeError(UsageError):
    """No device can have the requested type."""


def _print_table(door: DoorClient, options: argparse.Namespace) -> None:
    now = house_time(door)
    waiting = unapproved(door)
    rows = _all(door, options.type, lambda device: _row(device, now, waiting))
    if rows:
        print_table(_HEAD, rows, if_any=_IF_ANY, if_room=_IF_ROOM, if_wide=_IF_WIDE, in_colour="AVAILABILITY")
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
        first.gateway if first else "",
        _command_topic(device),
        life(device) + (", unapproved" if device.id in waiting else ""),
        ago(device.last_seen, now),
    )


def _command_topic(device: Device) -> str:
    for one in device.endpoints:
        if is_topic(one.command_address):
            return one.command_address
    return next((topic for part in main_parts(device) for topic in part.part.writes), "")


def add_find_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _find, _FIND_EXAMPLES)
    parser.add_argument("query", metavar="QUERY", nargs="+", help="search terms, see below")
    parser.add_argument("--why", action="store_true", help="show the reasons for each match and its rank")
    parser.add_argument("--limit", metavar="N", type=whole, default=50, help="show the N best matches (default: 50)")
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")


def _find(door: DoorClient, options: argparse.Namespace) -> int:
    query = " ".join(options.query)
    found = _found(door, query, options.limit)
    if options.json:
        waiting = unapproved(door)
        results = [
            device_json(one.device, waiting) | {"score": one.score, "reasons": one.reasons} for one in found.results
        ]
        print(list_text([json_text(one) for one in results]))
        return 0 if results else 1
    if found.results:
        note_near_matches(found)
        _show(found, why=options.why)
    else:
        print(why_none(door, query))
    _show_left_out(found)
    return 0 if found.results else 1


def _found(door: DoorClient, query: str, limit: int) -> QueryDevicesResponse:
    """Return the matches of *query*, or else the devices with that name: words of a name may be query words."""
    try:
        found = find_devices(door, query, limit)
    except PeerError:
        if named := _named(door, query, limit):
            return named
        raise
    return found if found.results else _named(door, query, limit) or found


def _named(door: DoorClient, name: str, limit: int) -> QueryDevicesResponse | None:
    query = f"name={quoted(name)}"
    found = find_devices(door, query, limit) if len(query) <= MAX_QUERY else None
    return found if found and found.results else None


def _show_left_out(found: QueryDevicesResponse) -> None:
    if found.message:
        print(f"homebot: {printable(found.message, _WIDEST)}", file=sys.stderr)
    for one in found.left_out:
        print(f"homebot: left out: {printable(one.key)}: {printable(one.value, _WIDEST)}", file=sys.stderr)


def _show(found: QueryDevicesResponse, *, why: bool) -> None:
    rows: list[tuple[str, ...]] = [
        (one.id, one.name, types(one), one.area, state_text(one), life(one))
        for one in (result.device for result in found.results)
    ]
    reasons = [one.reasons for one in found.results]
    if not why:
        print_table(_FIND_HEAD, rows, if_any=_FIND_IF_ANY, if_room=("NAME",), in_colour="AVAILABILITY")
    elif is_terminal():
        rows = [(*row, "; ".join(some)) for row, some in zip(rows, reasons, strict=True)]
        print_table((*_FIND_HEAD, "WHY"), rows, if_any=_FIND_IF_ANY, if_room=("NAME",), in_colour="AVAILABILITY")
    else:
        head, *lines = to_table(*without_empty(_FIND_IF_ANY, _FIND_HEAD, rows)).splitlines()
        print(head)
        for line, some in zip(lines, reasons, strict=True):
            print("\n    ".join([line, *some]))
    if hidden := found.total - len(found.results):
        print(f"… and {hidden} more; --limit shows more of them")
