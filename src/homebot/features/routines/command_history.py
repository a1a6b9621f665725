"""The last days of a running homebot as a recording, from its history and its journal."""

import sys
from collections.abc import Callable, Collection
from typing import Final

from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient
from homebot.devices import Device, FindDevices
from homebot.devices.history_messages import MAX_POINTS, HistorySeries, ReadHistory
from homebot.devices.journal_messages import JournalEntry, ReadJournalResponse
from homebot.devices.names import FIND_DEVICES, READ_HISTORY, READ_JOURNAL
from homebot.errors import PeerError
from homebot.features.routines.history_recording import history_recording
from homebot.messages.builtin_interfaces import Time
from homebot.messages.json import message_from_json
from homebot.recording.recording import Recording
from homebot.support.printable import printable

_MAX_WAIT_S: Final = 60.0
_MAX_PAGES: Final = 100


def read_house_history(door: DoorClient, seconds: float, is_wanted: Callable[[Device], bool]) -> Recording:
    """Return the last *seconds* of the house, with the values of the devices that are wanted.

    Raises:
        PeerError: No history is kept.
    """
    until = house_time(door)
    since = until - seconds
    span = {"since": _json(since), "until": _json(until)}
    devices = message_from_json(
        FindDevices.Response, door.call(FIND_DEVICES, {}, _MAX_WAIT_S), ignore_unknown=True
    ).devices
    series: list[HistorySeries] = []
    for one in filter(is_wanted, devices):
        answer = door.call(READ_HISTORY, {"device": one.id, "points": MAX_POINTS, **span}, _MAX_WAIT_S)
        if not answer["success"]:
            raise PeerError(str(answer["message"]))
        found_series = message_from_json(ReadHistory.Response, answer, ignore_unknown=True).series
        if not all(each.complete for each in found_series):
            print(f"of {printable(one.name)} only the newest {MAX_POINTS:,} values are tried", file=sys.stderr)
        series += found_series
    return history_recording(door.home, devices, series, _commands(door, span["since"]), since, until)


def _commands(door: DoorClient, since: dict[str, int]) -> Collection[JournalEntry]:
    """Return the commands, of at most a hundred thousand entries of the journal."""
    found: dict[str, JournalEntry] = {}
    until = Time(sec=0, nanosec=0)
    for _ in range(_MAX_PAGES):
        answer = door.call(READ_JOURNAL, {"since": since, "until": until.model_dump()}, _MAX_WAIT_S)
        page = message_from_json(ReadJournalResponse, answer, ignore_unknown=True)
        found |= {entry.command: entry for entry in page.entries if entry.kind == "requested"}
        if page.complete or not page.entries or page.entries[0].at == until:
            break
        until = page.entries[0].at
    return found.values()


def _json(at: float) -> dict[str, int]:
    return Time.from_seconds(at).model_dump()
