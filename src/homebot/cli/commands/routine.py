"""``homebot routine``."""

from __future__ import annotations

import argparse
from functools import partial
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import add_verb, add_verbs, set_command
from homebot.cli.device_json import json_text, list_text
from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.local_time import next_text, zone_of
from homebot.cli.terminal import print_line, print_table
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.devices.wording.time_format import ago
from homebot.errors import PeerError, UsageError
from homebot.support.folding import fold
from homebot.support.printable import printable
from homebot.support.similar import did_you_mean

if TYPE_CHECKING:
    from homebot.devices.app_messages import RoutineInfo, RoutinesResponse

__all__ = ["add_arguments"]

_EXAMPLES = """\
  homebot routine list                     the routines, and when a time starts each next
  homebot routine show 'Hall light'        its text, and what happened the last times
  homebot routine run 'Hall light'         start it now, whatever its conditions
  homebot routine disable 'Hall light'     do not let it start any more, also after a restart
  homebot routine enable 'Hall light'
  homebot routine try new.toml --on day.jsonl.gz    what the routines of a file would have done on a recorded day

Routines are the tables [[routines]] of homebot.toml; `homebot app reload hall_light` reads one again. `run`, `enable`
and `disable` need the right `manage`.
"""

_CHANGES = {
    "run": "start a routine now, whatever its conditions",
    "enable": "let a routine start",
    "disable": "do not let a routine start any more, and stop it",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the routines, and when a time starts each next")
    set_door_command(command, _list, "  homebot routine list --json\n")
    command.add_argument("--json", action="store_true", help="print a JSON list")
    command = add_verb(verbs, "show", "show a routine, and what happened the last times")
    set_door_command(command, _show, _EXAMPLES)
    command.add_argument("name", metavar="NAME", help="its name")
    command = add_verb(verbs, "try", "print what the routines of a file would have done on recorded days")
    set_command(command, _try, _EXAMPLES)
    command.add_argument("file", metavar="FILE", help="configuration with the routines")
    command.add_argument("--on", metavar="RECORDING", nargs="+", required=True, help="recording of `homebot record`")
    for change, summary in _CHANGES.items():
        command = add_verb(verbs, change, summary)
        set_door_command(command, partial(_change, change), _EXAMPLES)
        command.add_argument("name", metavar="NAME", help="its name")


def _try(options: argparse.Namespace) -> int:
    from homebot.cli.routine_trial import try_routines  # noqa: PLC0415 - a replay needs the whole runtime

    return try_routines(options)


def _routines(door: DoorClient) -> RoutinesResponse:
    return cast("RoutinesResponse", JsonMessage(door.call(LIST_ROUTINES, {})))


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    answer = _routines(door)
    if options.json:
        print(list_text([json_text(fields_of(one)) for one in answer.routines]))
    elif answer.routines:
        now, zone = house_time(door), zone_of(answer.zone)
        rows = [(printable(one.name), _state(one), next_text(one.next, now, zone)) for one in answer.routines]
        print_table(("ROUTINE", "STATE", "NEXT"), rows, if_any=("NEXT",))
    else:
        print("there is no routine; write one as a table [[routines]] in homebot.toml")
    return 0


def _state(routine: RoutineInfo) -> str:
    if not routine.enabled:
        return "disabled"
    last = printable(routine.notes[-1].text, 100) if routine.notes else "waiting"
    return "running" if routine.is_running else last


def _show(door: DoorClient, options: argparse.Namespace) -> int:
    routines = {one.name: one for one in _routines(door).routines}
    wanted = fold(options.name)
    found = next((one for one in routines.values() if wanted in {fold(one.name), fold(one.app)}), None)
    if found is None:
        hint = did_you_mean(options.name, routines, f"routines are {', '.join(routines) or 'none'}")
        raise UsageError(f"there is no routine {options.name!r}; {hint}")
    print_line(f"{printable(found.name)}{'' if found.enabled else ', disabled'} ({found.mode})")
    for word, texts in (("when", found.when), ("if", found.conditions), ("do", found.steps)):
        for text in texts:
            print_line(f"  {word:<5}{printable(text)}")
    now = house_time(door)
    for note in reversed(found.notes):
        print_line(f"  {ago(note.at, now)}: {printable(note.text, 300)}")
    return 0


def _change(change: str, door: DoorClient, options: argparse.Namespace) -> int:
    answer = door.call(CHANGE_ROUTINE, {"name": options.name, "change": change})
    text = printable(str(answer["message"]), 500)
    if not answer["success"]:
        raise PeerError(text)
    print(text)
    return 0
