"""``homebot why``."""

from __future__ import annotations

import argparse
import math

from homebot.cli.arguments import set_client_command
from homebot.cli.device_history import Chain, DeviceHistory, changed_at, is_first, is_live
from homebot.cli.device_json import json_text
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.history_words import UNEXPLAINED, chain_lines, reason_text
from homebot.cli.journal_client import JournalClient, chain_json
from homebot.cli.journal_words import ago_text
from homebot.cli.records import DeviceRecord
from homebot.cli.table import printable
from homebot.cli.terminal import print_line, print_rows
from homebot.cli.time_format import from_seconds, iso, to_seconds
from homebot.cli.values import state_text

__all__ = ["add_arguments"]

_FIRST = 5.0
"""Seconds after a device was first heard in which it tells how it is."""

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


def _why(options: argparse.Namespace) -> int:
    """Print why a device is as it is."""

    def run(door: DoorClient) -> int:
        device = named_device(door, options.device)
        client = JournalClient(door)
        client.names[device["id"]] = device["name"]
        history = DeviceHistory(client)
        chain = history.last_change(device)
        if options.json:
            print(json_text(_json(device, chain, client)))
        else:
            _tell(device, chain, history, client, house_time(door))
        return 0

    return with_client(options, run)


def _tell(device: DeviceRecord, chain: Chain | None, history: DeviceHistory, client: JournalClient, now: float) -> None:
    name = printable(device["name"] or device["id"])
    state = state_text(device)
    print_line(f"{name} is {state}." if state else f"{name} does not report its state.", "bold")
    if chain is not None:
        print(f"It changed {ago_text(chain.changed_at, now)}: {reason_text(chain, client.names)}.")
        if chain.first["kind"] != "changed":
            print()
            print_rows([*chain_lines(chain, client.names, now)])
    elif (at := changed_at(device)) and at <= to_seconds(device["first_seen"]) + _FIRST:
        print(f"It has been so since homebot first heard of it, {ago_text(at, now)}.")
    elif at and not is_live(device):
        print(f"It was so already {ago_text(at, now)}; a retained value does not tell since when.")
    elif at and is_first(device):
        print(f"It was so already {ago_text(at, now)}, when it first told how it is.")
    elif at:
        print(f"It changed {ago_text(at, now)}: {UNEXPLAINED}.")
    elif (command := history.newest_command(device)) is not None:
        print("It reported no change after the newest command.\n")
        print_rows([*chain_lines(command, client.names, now)])
    else:
        print("Nobody commanded it, and it reported no change.")


def _json(device: DeviceRecord, chain: Chain | None, client: JournalClient) -> dict[str, object]:
    at = changed_at(device)
    if chain is not None:
        at = min(at or math.inf, chain.changed_at)
    return {
        "device": device["id"],
        "name": device["name"],
        "state": state_text(device),
        "since": iso(from_seconds(at)) if at else None,
        "explained": chain is not None and chain.first["kind"] != "changed",
        "chain": [] if chain is None else chain_json(chain.all_entries, client.names),
    }
