"""``homebot why``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from homebot.cli.arguments import set_client_command
from homebot.cli.device_json import json_text
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, door_command
from homebot.cli.journal_client import JournalClient, chain_json
from homebot.cli.terminal import print_line, print_rows
from homebot.devices.wording.history_words import chain_lines, chains_of, finding_text
from homebot.devices.wording.journal_words import ago_text
from homebot.devices.wording.time_format import iso, to_seconds
from homebot.devices.wording.values import state_text
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device
    from homebot.devices.journal_messages import ExplainDeviceResponse

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot why 'Hall lamp'
  homebot why lights/roomlights405 --json

Tells why a device is as it is: its last change, who asked for it, what led to that, and what the device did. Where no
command explains the change, somebody did it by hand, or the device did it by itself.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add those of ``homebot why``."""
    set_client_command(parser, _why, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")


@door_command
def _why(door: DoorClient, options: argparse.Namespace) -> int:
    """Print why a device is as it is."""
    device = named_device(door, options.device)
    client = JournalClient(door)
    client.names[device.id] = device.name
    found = client.explain(device.id)
    if options.json:
        print(json_text(_json(device, found, client)))
    else:
        _print(device, found, client, house_time(door))
    return 0


def _print(device: Device, found: ExplainDeviceResponse, client: JournalClient, now: float) -> None:
    name = printable(device.name or device.id)
    state = state_text(device)
    print_line(f"{name} is {state}." if state else f"{name} does not report its state.", "bold")
    print(finding_text(found, client.names, now))
    chains = chains_of(found.entries)
    if chains and found.finding != "change":
        print()
        print_rows([*chain_lines(chains, client.names, now)])
    for fight in found.fights:
        print_line(f"{printable(fight.text)}, the last {ago_text(to_seconds(fight.newest), now)}.", "yellow")
    for route in dict.fromkeys(one.value for one in found.ineffective):
        print_line(f"The last commands via {printable(route)} had no effect: another way is tried first.", "yellow")


def _json(device: Device, found: ExplainDeviceResponse, client: JournalClient) -> dict[str, object]:
    return {
        "device": device.id,
        "name": device.name,
        "state": state_text(device),
        "since": iso(found.changed_at) if found.changed_at.sec else None,
        "explained": found.finding == "command",
        "chain": chain_json(found.entries, client.names) if found.finding != "none" else [],
        "ineffective_routes": [{"part": one.key, "route": one.value} for one in found.ineffective],
        "fights": [{"apps": list(one.issuers), "text": one.text, "last": iso(one.newest)} for one in found.fights],
    }
