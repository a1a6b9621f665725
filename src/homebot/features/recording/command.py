"""``homebot record``."""

import argparse
import time
from pathlib import Path
from typing import Final, cast

from homebot.cli.arguments import add_time_limit, positive, set_client_command
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.stop_signals import stop_signals
from homebot.errors import LinkError, RefusedError, UsageError
from homebot.features.recording import READ_RECORDING, START_RECORDER
from homebot.features.recording.recording_file import DEFAULT_MEGABYTES, RecordingFile

_EXAMPLES = """\
  homebot record day.jsonl.gz
  homebot record day.jsonl.gz --for 86400
  homebot replay day.jsonl.gz --diff

It records reports of devices and commands until Ctrl-C. Passwords and codes are left out. The file shows when people
were at home, so only you can read it. To record a run from its beginning: homebot run --record FILE.
"""

_MAX_WAIT_S: Final = 30.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    set_client_command(parser, _record, _EXAMPLES)
    parser.add_argument("file", metavar="FILE", help="file to write; compressed if its name ends in .gz")
    add_time_limit(parser)
    parser.add_argument(
        "--max-mb",
        metavar="MB",
        type=positive,
        default=DEFAULT_MEGABYTES,
        help=f"stop after this much text, before compression (default: {DEFAULT_MEGABYTES:g})",
    )
    parser.add_argument("--force", action="store_true", help="replace an existing file")


def _record(options: argparse.Namespace) -> int:
    path = Path(options.file)
    if path.exists() and not options.force:
        raise UsageError(f"{path} exists already; --force replaces it")
    return with_client(options, _record_into)


def _record_into(door: DoorClient, options: argparse.Namespace) -> int:
    answer = door.call(START_RECORDER.name, timeout=_MAX_WAIT_S)
    if not answer["success"]:
        raise RefusedError("recording", str(answer["message"]))
    with _create(door, options) as file:
        problem = _fetch(door, file, options.seconds)
    print(f"{file.path}: {file.lines:,} lines{f', {file.dropped:,} did not fit' if file.dropped else ''}")
    if problem is not None:
        raise problem
    return 0


def _create(door: DoorClient, options: argparse.Namespace) -> RecordingFile:
    """Return the new file; if it cannot be created, end the recorder, which would wait for this client."""
    try:
        return RecordingFile(Path(options.file), options.max_mb, force=options.force)
    except UsageError:
        while not door.call(READ_RECORDING.name, {"is_last": True}, _MAX_WAIT_S)["is_over"]:
            pass
        raise


def _fetch(door: DoorClient, file: RecordingFile, seconds: float | None) -> LinkError | OSError | None:
    """Write lines until interrupted, the time is up or the file is full; return the error that ended it earlier."""
    ends = None if seconds is None else time.monotonic() + seconds
    is_over = False
    with stop_signals() as stopped:
        while not is_over:
            is_last = bool(stopped) or file.is_full or (ends is not None and time.monotonic() >= ends)
            try:
                answer = door.call(READ_RECORDING.name, {"is_last": is_last}, _MAX_WAIT_S)
                file.write(cast("list[str]", answer["lines"]))
            except (LinkError, OSError) as exc:
                return exc
            is_over = bool(answer["is_over"])
    return None
