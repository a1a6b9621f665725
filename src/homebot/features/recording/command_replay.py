"""``homebot replay``."""

import argparse
import asyncio
import json
from collections.abc import Iterator, Mapping
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.arguments import set_command
from homebot.cli.remarks import print_error, remark
from homebot.config import load_config
from homebot.devices.device import part_names
from homebot.devices.wording.journal_words import trigger_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.errors import HomebotError
from homebot.features.recording.command_diff import CommandDiff, DifferentCommand, command_diff
from homebot.log import configure_logging
from homebot.messages.json import message_to_json
from homebot.recording.recording import Recording, TimedCommand, load_recording
from homebot.replay.command_matcher import command_text, device_text
from homebot.replay.replay import Replayed, replay, replay_config
from homebot.support.printable import printable
from homebot.support.virtual_time import VirtualTimeLoop

if TYPE_CHECKING:
    from homebot.recording.lines import RecordedCommand

_TROUBLE: Final = 2

_SIGNS = {"added": "+", "gone": "-"}

_EXAMPLES = """\
  homebot replay day.jsonl.gz --diff
  homebot replay day.jsonl.gz --app my_lights.py --diff
  homebot replay day.jsonl.gz --config homebot.toml --diff
  homebot replay day.jsonl.gz

The recorded day is repeated in virtual time: devices report what they reported then, and nothing is sent to any device.
With --diff, the exit code is 0 if the apps gave the same commands, 1 if they differ, and 2 after an error.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_command(parser, _replay, _EXAMPLES)
    parser.add_argument("file", metavar="FILE", help="recording of `homebot record`")
    parser.add_argument(
        "--app",
        metavar="APP",
        action="append",
        default=[],
        help="app to run in place of the recorded ones: a plug-in's name, module:Class or a Python file; may be given "
        "more than once",
    )
    parser.add_argument(
        "--config",
        metavar="FILE",
        help="configuration whose policies and app settings replace the recorded ones",
    )
    parser.add_argument("--diff", action="store_true", help="print added (+) and missing (-) commands")
    parser.add_argument("--json", action="store_true", help="print each command as one line of JSON")
    parser.add_argument("--log", action="store_true", help="show the log of the apps")


def difference_text(command: DifferentCommand, start: float, names: Mapping[str, str]) -> str:
    """Return a difference as a line that begins with ``+`` or ``-``."""
    where = "in the replay" if command.kind == "gone" else "in the recording"
    refused = f"; refused {where} by {printable(command.refused)}" if command.refused else ""
    return f"{_SIGNS[command.kind]} {command_text(replace(command.given, result=None), start, names)}{refused}"


def _replay(options: argparse.Namespace) -> int:
    configure_logging(level="info" if options.log else "critical")
    try:
        recording = load_recording(Path(options.file))
        given = load_config(Path(options.config)) if options.config else None
        config = replay_config(recording, options.app, given)
        with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
            loop = runner.get_loop()
            assert isinstance(loop, VirtualTimeLoop)  # noqa: S101 - for the type checker: it was made the line before
            replayed = runner.run(replay(recording, config, loop.settled))
    except HomebotError as exc:
        print_error(str(exc), as_json=options.json)
        return _TROUBLE
    for warning in _warnings(recording, replayed, has_log=options.log):
        remark(warning, as_json=options.json)
    names = part_names([*recording.devices.values(), *replayed.devices])
    start = recording.header.started_at.to_seconds()
    if not options.diff:
        if not replayed.commands:
            remark("no app gave a command; --app names another", as_json=options.json)
        for command in replayed.commands:
            print(
                json.dumps(_command_json(command, start, names))
                if options.json
                else command_text(command, start, names)
            )
        return 0
    diff = command_diff(recording.commands, replayed.commands, replayed.issuers, recording.ends_at)
    for difference in diff.different:
        print(
            json.dumps(_difference_json(difference, start, names))
            if options.json
            else difference_text(difference, start, names)
        )
    if not options.json:
        print(_summary_text(diff))
    return 1 if diff.different else 0


def _warnings(recording: Recording, replayed: Replayed, *, has_log: bool) -> Iterator[str]:
    for name, error in replayed.crashes.items():
        yield f"{name} crashed: {error}{'' if has_log else '; --log shows where'}"
    if recording.lost:
        why = "did not fit" if recording.end else "came too fast"
        yield f"the recording lacks {recording.lost:,} lines, which {why}"
    if recording.end or not recording.is_whole:
        why = recording.end or "homebot or the recorder stopped before its end"
        yield f"the recording ends early: {why}"


def _summary_text(diff: CommandDiff) -> str:
    added = sum(difference.kind == "added" for difference in diff.different)
    gone = len(diff.different) - added
    if not diff.different:
        return f"no difference: {'1 command is' if diff.same == 1 else f'{diff.same:,} commands are'} the same"
    return f"{added:,} added, {gone:,} gone, {diff.same:,} the same"


def _command_json(given: TimedCommand, start: float, names: Mapping[str, str]) -> dict[str, object]:
    """Return a command for programs; arguments as for :func:`_command_text`."""
    record = message_to_json(given.command)
    command = cast("RecordedCommand", JsonMessage(record))
    return {
        "at": datetime.fromtimestamp(start + given.at, UTC).isoformat(timespec="milliseconds"),
        "name": device_text(given, names),
        "because": trigger_text(command.trigger, names),
        **{key: value for key, value in record.items() if key not in {"id", "trigger"}},
        "outcome": "" if given.result is None else given.result.outcome,
    }


def _difference_json(command: DifferentCommand, start: float, names: Mapping[str, str]) -> dict[str, object]:
    return {"difference": command.kind, "refused": command.refused, **_command_json(command.given, start, names)}
