"""The last days of a house, read through the door for a trial of routines."""

from collections.abc import Mapping
from typing import Any, cast

from homebot.cli.door_client import DoorClient
from homebot.devices.names import FIND_DEVICES, READ_JOURNAL
from homebot.features.routines.command_history import read_house_history

COMMANDS = 2500
PAGE = 1000


class Door:
    """The door of a house in which an app gave a command in each of the last seconds."""

    home = "home"

    def call(self, service: str, request: Mapping[str, Any] | None = None, _: float = 10.0) -> dict[str, Any]:
        if service == READ_JOURNAL:
            assert request is not None
            return journal(request["since"]["sec"], request["until"]["sec"] or COMMANDS)
        if service == FIND_DEVICES:
            return {"devices": [], "sequence": 0}
        return {"time": {"sec": COMMANDS, "nanosec": 0}}


def journal(since: int, until: int) -> dict[str, Any]:
    fitting = range(since, until + 1)
    entries = [
        {"kind": "requested", "at": {"sec": at, "nanosec": 0}, "device": "lamp", "command": f"c{at}", "issuer": "/app"}
        for at in fitting[-PAGE:]
    ]
    return {"entries": entries, "complete": len(fitting) <= PAGE}


def test_all_commands_of_the_time_count_once_though_the_journal_answers_in_pages() -> None:
    recording = read_house_history(cast("DoorClient", Door()), COMMANDS - 100.0, lambda _: True)
    assert [one.command.id for one in recording.commands] == [f"c{at}" for at in range(100, COMMANDS + 1)]
