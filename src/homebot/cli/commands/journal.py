"""``homebot journal``, ``homebot why`` and ``homebot why-not``."""

from __future__ import annotations

import argparse
import json
import shlex
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Never, cast, final

from homebot.cli.arguments import duration, whole
from homebot.cli.device_json import chain_json, entry_json, json_text
from homebot.cli.device_queries import house_time, named_device
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.terminal import print_line, print_rows
from homebot.devices.names import EXPLAIN_DEVICE, EXPLAIN_MISSING_STATE, JOURNAL_ENTRIES, READ_JOURNAL
from homebot.devices.wording.journal_words import (
    Chain,
    ago_text,
    chain_lines,
    chains_of,
    clock_text,
    entry_text,
    finding_text,
    issuer_text,
    name_text,
    repeats,
    result_text,
    trigger_text,
    was_obeyed,
)
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import ago, from_seconds, iso
from homebot.devices.wording.values import state_text
from homebot.errors import UsageError
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices import Device, KeyValue
    from homebot.devices.journal_messages import (
        ExplainDeviceResponse,
        ExplainMissingStateResponse,
        JournalEntry,
        ReadJournalResponse,
    )

__all__ = ["add_arguments", "add_why_arguments", "add_why_not_arguments"]

_NO_DEVICE = "-"

_EXAMPLES = """\
  homebot journal
  homebot journal --follow
  homebot journal 'Kitchen lamp' --since 2h

Each step of each command and lease, each change of a device that no command explains (made by hand, or by the device
itself), and each request that the door refused. `homebot why DEVICE` explains the last change of a device.
"""

_MOST = 10

_WHY_EXAMPLES = """\
  homebot why 'Hall lamp'
  homebot why lights/roomlights405 --json

Explains the state of a device: its last change, the program that asked for it, the cause, and the device's answer. If
    no command explains the change, it was made by hand, or by the device itself.
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
    found = cast("ReadJournalResponse", client.ask(READ_JOURNAL, request))
    printer = _EntryPrinter(client, now, as_json=options.json)
    for entry in found.entries:
        printer.print(entry)
    if options.follow:
        _follow(door, client, printer, device, options.command_id)
    elif not options.json:
        _print_missing(found, now, is_filtered=bool(since or device or options.command_id))
    return 0


def _print_missing(found: ReadJournalResponse, now: float, *, is_filtered: bool) -> None:
    if not found.entries:
        print("nothing in the journal fits" if is_filtered else "the journal is empty")
    elif not found.complete:
        print(f"… there are older ones; the journal begins {ago(found.begins, now)}; --limit shows more")


def _follow(door: DoorClient, client: JournalClient, printer: _EntryPrinter, device: str, command: str) -> Never:
    """Print each new entry of *device* and *command*, empty for all, until Ctrl-C."""
    while True:
        entry = cast("JournalEntry", JsonMessage(door.next().message))
        if device in {"", entry.device} and command in {"", entry.command}:
            client.read_name(entry.device)
            client.read_name(entry.trigger.device)
            printer.print(entry)


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
            print(self._text(entry), flush=True)
        self._before = entry

    def _text(self, entry: JournalEntry) -> str:
        names = self._client.names
        cause = trigger_text(entry.trigger, names)
        text = entry_text(entry, names) + (f", because {cause}" if cause else "")
        name, command = name_text(entry.device, names, entry.part) or _NO_DEVICE, entry.command
        return f"{clock_text(entry.at, self._now)}  {name}  {command + '  ' if command else ''}{text}"


def add_why_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _why, _WHY_EXAMPLES)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("state", nargs="?", help=argparse.SUPPRESS)
    parser.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")


def add_why_not_arguments(parser: argparse.ArgumentParser) -> None:
    examples = """\
  homebot why-not 'Hall lamp' on
  homebot why-not 'Front door' locked --json

Lists the commands that asked a device for a state, with their outcomes; or says that nobody asked for it, that the
device is already in that state, or that it has no such state.
"""
    set_door_command(parser, _why_not, examples)
    parser.add_argument("device", metavar="DEVICE", help="its id or its name")
    parser.add_argument("state", metavar="STATE", help="the state it is not in: on, off, open, locked, 40, cleaning, …")
    parser.add_argument("--json", action="store_true", help="print a JSON object, times in ISO 8601 UTC")


def _why(door: DoorClient, options: argparse.Namespace) -> int:
    if options.state:
        asked = f"homebot why-not {shlex.quote(options.device)} {shlex.quote(options.state)}"
        raise UsageError(f"a state is asked for by `{asked}`")
    device = named_device(door, options.device)
    client = JournalClient(door, device)
    found = cast("ExplainDeviceResponse", client.ask(EXPLAIN_DEVICE, {"device": device.id}))
    if options.json:
        print(json_text(_json(device, found, client)))
    else:
        _print(device, found, client, house_time(door))
    return 0


def _print(device: Device, found: ExplainDeviceResponse, client: JournalClient, now: float) -> None:
    _print_state(device)
    print(finding_text(found, client.names, now))
    chains = chains_of(found.entries)
    if chains and found.finding != "change":
        print()
        print_rows([*chain_lines(chains, client.names, now)])
    for fight in found.fights:
        print_line(f"{printable(fight.text)}, the last {ago_text(fight.newest, now)}.", "yellow")
    for route in dict.fromkeys(one.value for one in found.ineffective):
        print_line(f"The last commands via {printable(route)} had no effect: another route is tried first.", "yellow")


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


def _why_not(door: DoorClient, options: argparse.Namespace) -> int:
    if not options.state.strip():
        raise UsageError("give the state that the device is not in, such as on, open or 40")
    device = named_device(door, options.device)
    client = JournalClient(door, device)
    request = {"device": device.id, "state": options.state}
    found = cast("ExplainMissingStateResponse", client.ask(EXPLAIN_MISSING_STATE, request))
    asked = chains_of(found.entries)
    if options.json:
        chains = [chain_json(one, client.names) for one in asked]
        shown = {"device": device.id, "state": state_text(device), "wanted": options.state}
        print(json_text({**shown, "is_so": found.is_so, "asked": chains}))
        return 0
    now = house_time(door)
    _print_state(device)
    if found.is_so:
        print(f"It is already {_wanted(options)}; `homebot why {_quoted(device)}` tells why.")
    if asked:
        _print_asked(asked, client, options, device, now, 1 if found.is_so else _MOST)
        if not found.is_so and was_obeyed(asked[-1]):
            print(f"\nIt changed after that: `homebot why {_quoted(device)}` tells why.")
    elif not found.is_so:
        print(_unasked(device, options, found, now))
    return 0


def _print_asked(
    asked: Sequence[Chain], client: JournalClient, options: argparse.Namespace, device: Device, now: float, most: int
) -> None:
    times = "once" if len(asked) == 1 else f"{len(asked)} times"
    print(f"{_wanted(options)} was asked for {times}:")
    print()
    print_rows([_row(one, client, now) for one in asked[-most:]])
    if len(asked) > most:
        print(f"  … the last {most} of {len(asked)}; all: homebot journal {_quoted(device)}")


def _unasked(device: Device, options: argparse.Namespace, found: ExplainMissingStateResponse, now: float) -> str:
    """Return why *device* is not in the wanted state if the journal has no command for it."""
    if found.problem:
        return printable(found.problem)
    begins = found.begins
    since = f" since the journal began, {ago_text(begins, now)}" if begins.sec else ""
    empty = "" if begins.sec else ": the journal is empty"
    how = f" To ask for it: homebot do {_quoted(device)} {printable(found.word)}" if found.word else ""
    return f"Nobody asked for {_wanted(options)}{since}{empty}.{how}"


def _print_state(device: Device) -> None:
    state = state_text(device)
    end = "" if state.endswith("…") else "."
    print_line(f"{_name(device)} is {state}{end}" if state else f"{_name(device)} does not report its state.", "bold")


def _name(device: Device) -> str:
    return printable(device.name or device.id)


def _quoted(device: Device) -> str:
    return shlex.quote(_name(device))


def _wanted(options: argparse.Namespace) -> str:
    return printable(options.state, 40)


def _row(chain: Chain, client: JournalClient, now: float) -> tuple[str, ...]:
    cause = trigger_text(chain[0].trigger, client.names)
    part = client.names.get(f"{chain[0].device}#{chain[0].part}", "")
    result = (f"{printable(part, 60)}: " if part else "") + result_text(chain, now)
    result += f" (asked because {cause})" if cause else ""
    return clock_text(chain[0].at, now), issuer_text(chain[0].issuer), result


@final
class JournalClient:
    """Reads the journal of a running homebot."""

    def __init__(self, door: DoorClient, *known: Device) -> None:
        self._door = door
        self.names = {one.id: one.name for one in known}

    def ask(self, service: str, request: Mapping[str, object]) -> JsonMessage:
        """Return the answer of a *service* of the journal.

        Raises:
            PeerError: The journal cannot be read; the message says why.
        """
        found = self._door.ask(service, request)
        names = cast("list[KeyValue]", found.names)
        self.names.update({one.key: one.value for one in names})
        return found

    def read_name(self, device: str) -> None:
        """Read the name of the device of an entry, unless it is known."""
        if device and device not in self.names:
            self.names[device] = device
            self.ask(READ_JOURNAL, {"device": device, "limit": 1})
