"""``homebot leases`` and ``homebot release``."""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, cast

from homebot.cli.device_json import json_text, list_text
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import print_table
from homebot.devices.names import END_LEASES, FIND_DEVICES, GET_LEASES
from homebot.devices.wording.journal_words import issuer_text, settings_text, trigger_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import age_text, iso, to_seconds
from homebot.devices.wording.values import plain_value
from homebot.errors import PeerError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.lease_messages import HeldPart, LeasesResponse
    from homebot.messages import Time

_HEAD = ("DEVICE", "HELD", "BY", "ISSUER", "FOR", "BECAUSE", "OUTRANKED")
_SEVERAL = 2
_EXAMPLES = """\
  homebot leases
  homebot leases 'Front door' --json

FOR is the time left, unless the holder renews its lease. BECAUSE is the cause, such as a call of a client. OUTRANKED is
the time for which a person's hand outranks the lease. `homebot release DEVICE` ends the leases of a device.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _leases, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", nargs="?", default="", help="only this device, by id or name")
    parser.add_argument("--json", action="store_true", help="print a JSON list, times in ISO 8601 UTC")


def add_release_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot release 'Front door'

Ends all leases of a device, of any holder; `homebot leases` shows them. It needs the right `manage`. The device stays
as it is. A program whose lease was ended cannot renew it: its block continues without it.
"""
    set_door_command(parser, _release, examples, acts=True)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")


def _leases(door: DoorClient, options: argparse.Namespace) -> int:
    device = named_device(door, options.device).id if options.device else ""
    parts = cast("LeasesResponse", JsonMessage(door.call(GET_LEASES, {"device": device}))).parts
    if options.json:
        print(list_text([json_text(_json(part)) for part in parts]))
    elif parts:
        now, labels = house_time(door), _labels(door, parts)
        rows = [row for part in parts for row in _rows(labels[part.device, part.part], part, now)]
        print_table(_HEAD, rows, if_any=("BECAUSE", "OUTRANKED"))
    else:
        print(f"nobody holds {printable(options.device)}" if device else "nobody holds anything")
    return 0


def _release(door: DoorClient, options: argparse.Namespace) -> int:
    device = named_device(door, options.device).id
    parts = cast("LeasesResponse", JsonMessage(door.call(END_LEASES, {"device": device, "issuer": ""}))).parts
    for held in parts:
        for holder in held.holders:
            by = f"{printable(holder.by, 60)} ({issuer_text(holder.issuer)})"
            print(f"{printable(device)} is no longer held {settings_text([held.setting])} by {by}")
    if not parts:
        raise PeerError(f"nobody holds {printable(device)}")
    return 0


def _labels(door: DoorClient, parts: Iterable[HeldPart]) -> dict[tuple[str, str], str]:
    """Return the ids of the held devices, each with its part if several take commands."""
    places = [(part.device, part.part) for part in parts]
    answer = JsonMessage(door.call(FIND_DEVICES, {"ids": sorted({device for device, _ in places})}))
    simple = {
        device.id
        for device in cast("list[Device]", answer.devices)
        if sum(any(can.settable for can in part.part.capabilities) for part in device.parts) < _SEVERAL
    }
    return {
        (device, part): printable(f"{device}#{part}" if part and device not in simple else device)
        for device, part in places
    }


def _rows(label: str, held: HeldPart, now: float) -> Iterator[tuple[str, ...]]:
    outranked = ""
    if held.outranked_until.sec:
        outranked = f"{_left(held.outranked_until, now)}: {printable(held.saw, 60)}"
    for holder in held.holders:
        yield (
            label,
            settings_text([held.setting]),
            printable(holder.by, 60),
            issuer_text(holder.issuer),
            _left(holder.until, now),
            trigger_text(holder.trigger, {}),
            outranked,
        )


def _left(until: Time, now: float) -> str:
    return age_text(to_seconds(until) - now) if until.sec else "released"


def _json(held: HeldPart) -> dict[str, object]:
    is_outranked = held.outranked_until.sec
    return {
        "device": held.device,
        "part": held.part,
        "capability": held.setting.capability,
        "value": plain_value(held.setting.value),
        "holders": [
            {
                "by": holder.by,
                "issuer": holder.issuer,
                "until": iso(holder.until) if holder.until.sec else None,
                "because": trigger_text(holder.trigger, {}),
            }
            for holder in held.holders
        ],
        "outranked_until": iso(held.outranked_until) if is_outranked else None,
        "saw": held.saw,
    }
