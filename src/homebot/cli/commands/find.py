"""``homebot find``."""

from __future__ import annotations

import argparse
import json

from homebot.cli.device_json import device_json
from homebot.cli.device_queries import find_devices
from homebot.cli.door_client import DoorClient
from homebot.cli.table import to_table, without_empty
from homebot.cli.terminal import is_terminal, print_table
from homebot.cli.values import life, state_text, types
from homebot.cli.with_client import with_client
from homebot.devices.services import QueryDevicesResponse

__all__ = ["find"]

_HEAD = ("DEVICE", "NAME", "TYPE", "AREA", "STATE", "AVAILABILITY")
_IF_ANY = ("AREA", "STATE")


def find(options: argparse.Namespace) -> int:
    """Print what fits a query, best first; return 1 where nothing does."""
    query = " ".join(options.query)

    async def run(door: DoorClient) -> int:
        found = await find_devices(door, query, options.limit)
        if options.json:
            results = [
                device_json(one.device) | {"score": one.score, "reasons": list(one.reasons)} for one in found.results
            ]
            print(json.dumps(results, indent=2))
        elif not found.results:
            print(f"no device matches {query!r}; `homebot devices` lists all")
        else:
            _show(found, why=options.why)
        return 0 if found.results else 1

    return with_client(options, run)


def _show(found: QueryDevicesResponse, *, why: bool) -> None:
    rows: list[tuple[str, ...]] = [
        (one.device.id, one.device.name, types(one.device), one.device.area, state_text(one.device), life(one.device))
        for one in found.results
    ]
    reasons = [one.reasons for one in found.results]
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
    if found.total > len(found.results):
        print(f"… and {found.total - len(found.results)} more; --limit shows more of them")
