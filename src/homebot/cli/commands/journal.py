"""``homebot journal``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import duration, whole
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.journal_client import JournalClient, entry_json
from homebot.devices.names import JOURNAL_ENTRIES, READ_JOURNAL
from homebot.devices.wording.journal_words import caused_text, clock_text, name_text, repeats
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import ago, from_seconds

if TYPE_CHECKING:
    from homebot.devices.journal_messages import (
        JournalEntry,
        ReadJournalResponse,
    )

_NO_DEVICE = "-"

_EXAMPLES = """\
  homebot journal
  homebot journal --follow
  homebot journal 'Kitchen lamp' --since 2h

Each step of each command and lease, each change of a device that no command explains (made by hand, or by the device
itself), and each request that the door refused. `homebot why DEVICE` explains the last change of a device.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _journal, _EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", nargs="?", help="only entries about this device, by id or name")
    parser.add_argument(
        "--command", metavar="ID", default="", dest="command_id", help="only entries about this command"
    )
    parser.add_argument(
        "--since", metavar="SPAN", type=duration, help="only entries of the last SPAN, such as 30m or 2d"
    )
    parser.add_argument("--limit", metavar="N", type=whole, default=50, help="show the N newest entries (default: 50)")
    parser.add_argument("--follow", action="store_true", help="then print new entries until Ctrl-C")
    parser.add_argument("--json", action="store_true", help="print each entry as one line of JSON")


def _journal(door: DoorClient, options: argparse.Namespace) -> int:
    client = JournalClient(door)
    device = named_device(door, options.device).id if options.device else ""
    now = house_time(door)
    if options.follow:
        door.subscribe(JOURNAL_ENTRIES)
    since = max(0.0, now - options.since) if options.since is not None else 0.0
    request = {"device": device, "command": options.command_id, "since": from_seconds(since), "limit": options.limit}
    response = cast("ReadJournalResponse", client.ask(READ_JOURNAL, request))
    printer = _EntryPrinter(client, now, as_json=options.json)
    for entry in response.entries:
        printer.print(entry)
    if options.follow:
        while True:
            new = cast("JournalEntry", JsonMessage(door.next().message))
            if device in {"", new.device} and options.command_id in {"", new.command}:
                client.read_name(new.device)
                client.read_name(new.trigger.device)
                printer.print(new)
    elif not options.json:
        if not response.entries:
            is_filtered = since or device or options.command_id
            print("nothing in the journal fits" if is_filtered else "the journal is empty")
        elif not response.complete:
            print(f"… there are older ones; the journal begins {ago(response.begins, now)}; --limit shows more")
    return 0


class _EntryPrinter:
    """Prints entries in order; as text it leaves out those that repeat the previous one."""

    def __init__(self, client: JournalClient, now: float, *, as_json: bool) -> None:
        self._client = client
        self._now = now
        self._as_json = as_json
        self._before: JournalEntry | None = None

    def print(self, entry: JournalEntry) -> None:
        """Print *entry* in one line."""
        if self._as_json:
            print(json.dumps(entry_json(entry, self._client.names)), flush=True)
        elif not repeats(entry, self._before):
            names = self._client.names
            text = caused_text(entry, names)
            name, command = name_text(entry.device, names, entry.part) or _NO_DEVICE, entry.command
            print(f"{clock_text(entry.at, self._now)}  {name}  {command + '  ' if command else ''}{text}", flush=True)
        self._before = entry
