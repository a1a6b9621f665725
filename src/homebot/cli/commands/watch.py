"""``homebot watch``."""

from __future__ import annotations

import argparse
import json
import shutil
import sys
import time
from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, Never, cast

from homebot.cli.device_queries import find_devices, matching_devices, why_none
from homebot.cli.door_client import DoorClient, ReceivedMessage, set_door_command
from homebot.cli.remarks import remark
from homebot.cli.terminal import is_terminal
from homebot.cli.watch_lines import HouseLines, WatchLine, fitted, line_cells
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, JOURNAL_ENTRIES
from homebot.devices.wording.journal_words import clock_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import iso
from homebot.support.output import CleanText, wants_colour
from homebot.words.tokens import quoted

if TYPE_CHECKING:
    from homebot.devices import Device, DeviceChange, StateChange
    from homebot.devices.journal_messages import JournalEntry

MAX_LINES: Final = 50
"""The limit of lines per second; the others are counted."""

_TICK: Final = 0.25
_COLOURS: Final = {"change": "", "command": "36", "outcome": "33"}

_EXAMPLES = """\
  homebot watch
  homebot watch 'light in kitchen'
  homebot watch --json | jq .device

One line for each changed value and each command, until Ctrl-C: time, device, value (→ is a command), cause, and the
program that commanded it. QUERY is as in `homebot find`. Lines beyond 50 a second are counted.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_door_command(parser, _watch, _EXAMPLES)
    parser.add_argument("query", metavar="QUERY", nargs="*", help="only devices that match, as in `homebot find`")
    parser.add_argument("--json", action="store_true", help="print each line as a JSON object")


def _watch(door: DoorClient, options: argparse.Namespace) -> Never:
    query = " ".join(options.query)
    house = _WatchedHouse(door, query)
    if query and not house.names:
        remark(f"so far {why_none(find_devices(door, query, 1), query)}", as_json=options.json)
    printer = _LinePrinter(house.names, as_json=options.json)
    while True:
        for message in door.until(_TICK):
            house.add(message)
            _print_due(house, printer)
        _print_due(house, printer)


def _print_due(house: _WatchedHouse, printer: _LinePrinter) -> None:
    now = time.monotonic()
    for line in house.lines.pop(now):
        if house.shows(line):
            printer.print(line, now)
    printer.end_second(now)


class _WatchedHouse:
    """The devices that match a query, and the lines about them."""

    def __init__(self, door: DoorClient, query: str) -> None:
        self._door = door
        self._query = query
        self._ids: set[str] = set()
        self._minor: set[tuple[str, str]] = set()
        self.names: dict[str, str] = {}
        self.lines = HouseLines(self.names)
        for topic in (DEVICE_CHANGES, DEVICE_STATES, JOURNAL_ENTRIES):
            door.subscribe(topic)
        for device in matching_devices(door, query):
            self._learn(device)

    def add(self, message: ReceivedMessage) -> None:
        """Add a message of a topic."""
        now, content = time.monotonic(), JsonMessage(message.message)
        if message.topic == DEVICE_STATES:
            self.lines.add_change(cast("StateChange", content), now)
        elif message.topic == JOURNAL_ENTRIES:
            self.lines.add_entry(cast("JournalEntry", content), now)
        else:
            device = cast("DeviceChange", content).device
            if device.id not in self._ids and self._fits(device.id):
                self._learn(device)

    def shows(self, line: WatchLine) -> bool:
        """Return whether *line* is about a matching device, but not about its settings or diagnostics."""
        is_minor = line.kind == "change" and (line.device, line.part) in self._minor
        return not is_minor and (not self._query or line.device in self._ids)

    def _fits(self, device: str) -> bool:
        query = f"({self._query}) and id={quoted(device)}"
        return not self._query or bool(find_devices(self._door, query, 1).results)

    def _learn(self, device: Device) -> None:
        self._ids.add(device.id)
        self.names[device.id] = device.name or device.id
        takes = [part for part in device.parts if any(can.settable for can in part.part.capabilities)]
        if len(takes) > 1:
            self.names |= {
                f"{device.id}#{part.id}": f"{device.name} {part.part.name}" for part in takes if part.part.name
            }
        self._minor |= {(device.id, part.id) for part in device.parts if part.part.category}
        self.lines.learn(device.id, device.states)


class _LinePrinter:
    """Prints lines up to the limit per second, and the number of others at its end."""

    def __init__(self, names: Mapping[str, str], *, as_json: bool) -> None:
        self._names = names
        self._as_json = as_json
        self._second = 0.0
        self._printed = self._more = 0
        raw = sys.stdout.raw if isinstance(sys.stdout, CleanText) else sys.stdout
        self._out = raw
        self._is_coloured = wants_colour(raw)

    def print(self, line: WatchLine, now: float) -> None:
        """Print *line*, or count it."""
        self.end_second(now)
        if self._printed >= MAX_LINES:
            self._more += 1
            return
        self._printed += 1
        self._write(self._json(line) if self._as_json else self._text(line), _COLOURS[line.kind])

    def end_second(self, now: float) -> None:
        """Print the number of lines left out in the second that has ended."""
        if now - self._second < 1.0:
            return
        if self._more:
            self._write(json.dumps({"more": self._more}) if self._as_json else f"… {self._more:,} more", "2")
        self._second, self._printed, self._more = now, 0, 0

    def _write(self, text: str, colour: str) -> None:
        is_coloured = self._is_coloured and colour and not self._as_json
        self._out.write(f"\x1b[{colour}m{text}\x1b[0m\n" if is_coloured else f"{text}\n")
        self._out.flush()

    def _text(self, line: WatchLine) -> str:
        stamp = clock_text(line.at, time.time())
        width = shutil.get_terminal_size().columns if is_terminal() else None
        return fitted(line_cells(line, self._names, stamp), width)

    def _json(self, line: WatchLine) -> str:
        fields = {
            "at": iso(line.at),
            "kind": line.kind,
            "device": line.device,
            "part": line.part,
            "name": self._names.get(line.device, ""),
            "values": line.values,
            "text": line.value,
            "why": line.why,
            "issuer": line.issuer,
        }
        return json.dumps({key: value for key, value in fields.items() if value != ""}, ensure_ascii=False)
