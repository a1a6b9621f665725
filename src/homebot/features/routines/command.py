"""``homebot routine``."""

from __future__ import annotations

import argparse
import shlex
from functools import partial
from typing import TYPE_CHECKING, cast

from homebot.cli.arguments import add_verb, add_verbs, set_client_command, set_command
from homebot.cli.device_json import json_text, list_text
from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient, set_door_command
from homebot.cli.local_time import next_text, zone_of
from homebot.cli.owner_language import owner_language
from homebot.cli.terminal import print_line, print_table
from homebot.cli.text_editor import edited, read_text
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES
from homebot.devices.wording.json_message import JsonMessage, fields_of
from homebot.devices.wording.time_format import ago
from homebot.errors import HomebotError, PeerError, UsageError
from homebot.support.names import find_name, resolve_name
from homebot.support.printable import printable

if TYPE_CHECKING:
    from homebot.devices.app_messages import RoutineInfo, RoutinesResponse

_EXAMPLES = """\
  homebot routine list                     the routines, and when a time starts each next
  homebot routine show 'Hall light'        its text, and what happened the last times
  homebot routine run 'Hall light'         start it now, whatever its conditions
  homebot routine disable 'Hall light'     do not let it start any more, also after a restart
  homebot routine enable 'Hall light'
  homebot routine new evening.toml         add the routines of a file; without one, write one in your editor
  homebot routine edit 'Hall light'        change it in your editor
  homebot routine edit 'Hall light' --act 'lock in hall'    let it command that as well; `act` in its text says all
  homebot routine remove 'Hall light'
  homebot routine gallery                  ready-made routines: motion light, laundry, window and heating …
  homebot routine import automations.yaml > new.toml    those of another program; lists what it leaves out
  homebot routine try new.toml --on last-week       what the routines of a file would have done, by the history
  homebot routine try new.toml --on day.jsonl.gz    the same on a recorded day, also with the ways of robots

Routines are the tables [[routines]] of homebot.toml, which you change there (`homebot app reload hall_light` reads one
again), and those that `new` adds, which homebot keeps. All but `list`, `show` and `try` need the right `manage`.
"""

_GALLERY_EXAMPLES = """\
  homebot routine gallery
  homebot routine gallery night_light
  homebot routine gallery night_light motion='hall motion' lamp='hall lamp' | homebot routine new -
"""

_TEMPLATE = """\
[[routines]]
name = ""
when = [""]   # any of: "hall motion occupied", "22:00 on weekdays", "sunset - 30m", "hall button press"
if = []       # all of: "sun is down", "nobody in study", "after 22:00"
do = [""]     # "hall lamp on, 20 %", "wait 5m", "wait until hall motion clear for 2m, at most 30m", "undo"
"""

_MAX_WAIT_S = 60.0
"""Seconds: an app may take ten to stop and ten to start, twice if it is rolled back."""

_CHANGES = {
    "run": "start a routine now, whatever its conditions",
    "enable": "let a routine start",
    "remove": "remove a routine that `new` added",
    "disable": "do not let a routine start any more, and stop it",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    verbs = add_verbs(parser, _EXAMPLES)
    command = add_verb(verbs, "list", "list the routines, and when a time starts each next")
    set_door_command(command, _list, "  homebot routine list --json\n")
    command.add_argument("--json", action="store_true", help="print a JSON list")
    command = add_verb(verbs, "show", "show a routine, and what happened the last times")
    set_door_command(command, show, _EXAMPLES)
    command.add_argument("name", metavar="NAME", help="its name")
    command = add_verb(verbs, "try", "print what the routines of a file would have done on recorded days")
    set_client_command(command, _try, _EXAMPLES)
    command.add_argument("file", metavar="FILE", help="configuration with the routines")
    command.add_argument(
        "--on",
        metavar="RECORDING|TIME",
        nargs="+",
        help="recording of `homebot record`, or last-week (default), last-day, 3d or 12h of the house's history",
    )
    command = add_verb(verbs, "new", "add routines, which homebot keeps")
    set_door_command(command, _new, _EXAMPLES)
    command.add_argument("file", metavar="FILE", nargs="?", help="tables [[routines]]; - for the standard input")
    _add_act(command)
    command = add_verb(verbs, "edit", "change a routine that `new` added")
    set_door_command(command, _edit, _EXAMPLES)
    command.add_argument("name", metavar="NAME", help="its name")
    command.add_argument("file", metavar="FILE", nargs="?", help="its new text; - for the standard input")
    _add_act(command)
    command = add_verb(verbs, "gallery", "list ready-made routines, or print one with your devices")
    set_command(command, _gallery, _GALLERY_EXAMPLES)
    command.add_argument("name", metavar="NAME", nargs="?", help="ready-made routine; alone, its inputs are listed")
    command.add_argument("inputs", metavar="INPUT=VALUE", nargs="*", help="your devices and values")
    command = add_verb(verbs, "import", "print the automations of another program as routines")
    set_door_command(command, _import, _EXAMPLES)
    command.add_argument("file", metavar="FILE", help="its automations, such as automations.yaml; - for standard input")
    command.add_argument("--blueprint", metavar="FILE", default="", help="the blueprint that they use")
    for change, summary in _CHANGES.items():
        command = add_verb(verbs, change, summary)
        set_door_command(command, partial(_change, change), _EXAMPLES)
        command.add_argument("name", metavar="NAME", help="its name")


def _add_act(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--act", metavar="QUERY", action="append", default=[], help="let it command these too, which may always ask"
    )


def _try(options: argparse.Namespace) -> int:
    from homebot.features.routines.command_trial import try_routines  # noqa: PLC0415 - a replay needs the whole runtime

    return try_routines(options)


def _routines(door: DoorClient) -> RoutinesResponse:
    return cast("RoutinesResponse", JsonMessage(door.call(LIST_ROUTINES, {"check": True}, _MAX_WAIT_S)))


def _list(door: DoorClient, options: argparse.Namespace) -> int:
    answer = _routines(door)
    if options.json:
        print(list_text([json_text(fields_of(one)) for one in answer.routines]))
    elif answer.routines:
        now, zone = house_time(door), zone_of(answer.zone)
        rows = [(printable(one.name), _state(one), next_text(one.next, now, zone)) for one in answer.routines]
        print_table(("ROUTINE", "STATE", "NEXT"), rows, if_any=("NEXT",))
        for one in answer.routines:
            _print_hints(one)
    else:
        print("there is no routine; write one: homebot routine new")
    return 0


def _state(routine: RoutineInfo) -> str:
    if routine.problem:
        return "wrong"
    if not routine.enabled:
        return f"proposed by {printable(routine.proposed_by)}" if routine.proposed_by else "disabled"
    last = printable(routine.notes[-1].text, 100) if routine.notes else "waiting"
    last = f"of a habit: {last}" if routine.of_habit else last
    return "running" if routine.is_running else last


def _named(door: DoorClient, name: str) -> RoutineInfo:
    infos = [*_routines(door).routines]
    named = {spelled: info for info in infos for spelled in (info.app, info.name)}
    known = ", ".join(info.name for info in infos) or "none"
    return named[resolve_name("routine", name, named, f"routines are {known}")]


def show(door: DoorClient, options: argparse.Namespace) -> int:
    """Print the routine of the name in *options*, and what happened the last times."""
    found = _named(door, options.name)
    if found.problem:
        print_line(f"{printable(found.name)} does not run: {printable(found.problem, 500)}", "yellow")
        print(printable(found.text, 5000))
        return 0
    by = f", proposed by {printable(found.proposed_by)}" if found.proposed_by else ""
    print_line(f"{printable(found.name)}{by}{'' if found.enabled else ', disabled'} ({found.mode})")
    for word, texts in (("when", found.when), ("if", found.conditions), ("do", found.steps)):
        for text in texts:
            print_line(f"  {word:<5}{printable(text)}")
    if found.act:
        print_line(f"  {'act':<5}{printable(', '.join(found.act))}")
    _print_hints(found)
    now = house_time(door)
    for note in reversed(found.notes):
        print_line(f"  {ago(note.at, now)}: {printable(note.text, 300)}")
    return 0


def _new(door: DoorClient, options: argparse.Namespace) -> int:
    return _write(door, {"change": "new", "act": options.act}, options.file, _TEMPLATE)


def _edit(door: DoorClient, options: argparse.Namespace) -> int:
    found = _named(door, options.name)
    if not found.is_kept and options.file is None:
        raise UsageError(f"{found.name} is in the configuration; change it there: homebot app reload {found.app}")
    request = {"change": "edit", "name": found.name, "act": options.act}
    if options.act and options.file is None:
        return _ask(door, request)
    return _write(door, request, options.file, found.text)


def _write(door: DoorClient, request: dict[str, object], file: str | None, text: str) -> int:
    """Send the text of *file*, or *text* as it is edited, which is kept if it has a mistake."""
    if file is not None:
        return _ask(door, {**request, "text": read_text(file)}, file)
    text, path = edited(text)
    try:
        _ask(door, {**request, "text": text})
    except PeerError as exc:
        raise UsageError(f"{exc}; your text is in {path}") from exc
    path.unlink()
    return 0


def _print_hints(routine: RoutineInfo) -> None:
    for hint in filter(None, (routine.problem, *routine.hints)):
        print_line(f"{printable(routine.name)}: {printable(hint, 500)}", "yellow")


def _gallery(options: argparse.Namespace) -> int:
    from homebot.features.routines.gallery import listed, ready_made  # noqa: PLC0415 - reads its files

    language = owner_language()
    known = {one.name: one for one in listed(language)}
    if not options.name:
        print_table(("ROUTINE", "ABOUT"), [(name, one.about) for name, one in known.items()])
        return 0
    routine = ready_made(options.name)
    if options.inputs or not routine.inputs:
        print(routine.filled(dict(map(_input, options.inputs)), language), end="")
        return 0
    shown = known[find_name(options.name, known)]
    print_line(shown.about)
    rows = [(one.key, one.label, one.default or f"homebot find {shlex.quote(one.find)}") for one in shown.inputs]
    print_table(("INPUT", "WHAT", "BY DEFAULT, OR WHAT FITS"), rows)
    return 0


def _input(text: str) -> tuple[str, str]:
    key, equals, value = text.partition("=")
    if not equals:
        raise UsageError(f"{text!r} is no input; write it like lamp='hall lamp'")
    return key, value


def _import(door: DoorClient, options: argparse.Namespace) -> int:
    from homebot.features.routines.command_import import import_routines  # noqa: PLC0415 - reads YAML

    return import_routines(door, options.file, options.blueprint)


def _change(change: str, door: DoorClient, options: argparse.Namespace) -> int:
    if change == "enable":
        _print_trial(door, _named(door, options.name))
    return _ask(door, {"name": options.name, "change": change})


def _print_trial(door: DoorClient, routine: RoutineInfo) -> None:
    """Print a summary of a trial of a routine in the last week, if a history is kept."""
    from homebot.features.routines.command_trial import LAST, given_of, history_lines  # noqa: PLC0415 - a replay needs the runtime

    try:
        lines = history_lines(door, given_of(routine.text, routine.name), LAST["last-week"], "the last week")
    except HomebotError as exc:
        lines = [f"no trial: {exc}"]
    print_line(printable(lines[-1], 500))


def _ask(door: DoorClient, request: dict[str, object], file: str = "") -> int:
    answer = door.call(CHANGE_ROUTINE, request, timeout=_MAX_WAIT_S)
    lines = [printable(line, 2000) for line in str(answer["message"]).splitlines()]
    if not answer["success"]:
        raise PeerError("\n".join(line.replace("the text:", f"{file or 'the text'}:", 1) for line in lines))
    for line in lines:
        print(line)
    return 0
