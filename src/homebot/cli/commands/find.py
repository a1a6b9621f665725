"""``homebot find``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from homebot.cli.arguments import whole
from homebot.cli.device_json import device_json, json_text, list_text
from homebot.cli.device_queries import find_devices, print_note, unapproved, why_none
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.remarks import remark
from homebot.cli.terminal import is_terminal, print_table, to_table, without_empty
from homebot.devices.wording.values import life, state_text, types
from homebot.errors import PeerError
from homebot.support.printable import printable
from homebot.words.tokens import MAX_QUERY, quoted

if TYPE_CHECKING:
    from homebot.devices.services import QueryDevicesResponse

_HEAD = ("DEVICE", "NAME", "TYPE", "AREA", "STATE", "AVAILABILITY")
_IF_ANY = ("AREA", "STATE")
_WIDEST = 300


_EXAMPLES = """\
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
    set_door_command(parser, _find, _EXAMPLES)
    parser.add_argument("query", metavar="QUERY", nargs="*", help="search terms, see below (default: all)")
    parser.add_argument("--why", action="store_true", help="show the reasons for each match and its rank")
    parser.add_argument("--limit", metavar="N", type=whole, default=50, help="show the N best matches (default: 50)")
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")


def _find(door: DoorClient, options: argparse.Namespace) -> int:
    query = " ".join(options.query)
    answer = _found(door, query, options.limit)
    if answer.results or answer.pose_age:
        print_note(answer, as_json=options.json)
    for item in answer.left_out:
        text = f"left out: {printable(item.key)}: {printable(item.value, _WIDEST)}"
        remark(text, as_json=options.json)
    if options.json:
        if not answer.results:
            remark(why_none(answer, query), as_json=True)
        waiting = unapproved(door)
        results = [
            device_json(result.device, waiting) | {"score": result.score, "reasons": result.reasons}
            for result in answer.results
        ]
        print(list_text([json_text(result) for result in results]))
        return 0 if results else 1
    if not answer.results:
        print(why_none(answer, query))
    else:
        _show(answer, why=options.why)
    return 0 if answer.results else 1


def _found(door: DoorClient, query: str, limit: int) -> QueryDevicesResponse:
    """Return the matches of *query*, or else the devices with that name: words of a name may be query words."""
    try:
        devices = find_devices(door, query, limit)
    except PeerError:
        if named := _named(door, query, limit):
            return named
        raise
    return devices if devices.results else _named(door, query, limit) or devices


def _named(door: DoorClient, name: str, limit: int) -> QueryDevicesResponse | None:
    query = f"name={quoted(name)}"
    devices = find_devices(door, query, limit) if len(query) <= MAX_QUERY else None
    return devices if devices and devices.results else None


def _show(response: QueryDevicesResponse, *, why: bool) -> None:
    rows: list[tuple[str, ...]] = [
        (device.id, device.name, types(device), device.area, state_text(device), life(device))
        for device in (result.device for result in response.results)
    ]
    reasons = [result.reasons for result in response.results]
    if not why:
        print_table(_HEAD, rows, if_any=_IF_ANY, if_room=("NAME",), in_colour="AVAILABILITY")
    elif is_terminal():
        rows = [(*row, "; ".join(some)) for row, some in zip(rows, reasons, strict=True)]
        print_table((*_HEAD, "WHY"), rows, if_any=_IF_ANY, if_room=("NAME",), in_colour="AVAILABILITY")
    else:
        head, *lines = to_table(*without_empty(_IF_ANY, _HEAD, rows)).splitlines()
        print(head)
        for line, some in zip(lines, reasons, strict=True):
            print("\n    ".join([line, *some]))
    if hidden := response.total - len(response.results):
        print(f"… and {hidden} more; --limit shows more of them")
