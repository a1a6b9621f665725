"""``homebot routine try``: prints what routines would have done on recorded days."""

import argparse
import asyncio
from collections import Counter
from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final

from homebot.cli.commands.replay import command_text
from homebot.cli.door_client import DoorClient, with_client
from homebot.cli.house_history import read_house_history
from homebot.config import Config, load_config, parse_settings
from homebot.devices.device import part_names
from homebot.devices.wording.time_format import age_text
from homebot.errors import UsageError
from homebot.log import configure_logging
from homebot.recording.recording import Recording, load_recording
from homebot.replay.replay import Replayed, replay
from homebot.replay.routine_trial import TriedCommand, routines_of, trial_config, tried
from homebot.routines.checks import asked_about
from homebot.routines.settings import RoutineSettings
from homebot.support.printable import printable
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.units import parse_duration

__all__ = ["LAST", "print_trial", "try_on_history", "try_routines"]


LAST: Final = {"last-day": 86_400.0, "last-week": 7 * 86_400.0}


def try_routines(options: argparse.Namespace) -> int:
    """Replay each recording with the routines of the file, and print their commands; nothing is sent."""
    given = load_config(Path(options.file))
    for source in options.on or ["last-week"]:
        seconds = LAST.get(source) or (parse_duration(source) if source[-1] in "dh" and source[:-1].isdigit() else 0.0)
        if seconds:
            try_on_history(options, given, seconds, source)
        else:
            print_trial(source, load_recording(Path(source)), given)
    return 0


def try_on_history(options: argparse.Namespace, given: Config, seconds: float, title: str) -> None:
    """Print what the routines of *given* would have done in the last *seconds* of a running homebot."""
    wanted = asked_about(parse_settings(RoutineSettings, one, given.source, name) for name, one in routines_of(given))
    recordings: list[Recording] = []

    def read(door: DoorClient, _: argparse.Namespace) -> int:
        recordings.append(read_house_history(door, seconds, wanted))
        return 0

    with_client(options, read)
    print_trial(title, recordings[0], given)


def print_trial(title: str, recording: Recording, given: Config) -> None:
    """Print what the routines of *given* would have done in the time of *recording*.

    Raises:
        UsageError: A routine crashed.
    """
    configure_logging(level="critical")
    config = trial_config(recording, given)
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, VirtualTimeLoop)  # noqa: S101 - for the type checker: it was made the line before
        replayed = runner.run(replay(recording, config, loop.settled))
    if replayed.crashes:
        name, error = next(iter(replayed.crashes.items()))
        raise UsageError(f"{name} crashed: {error}")
    found = tuple(tried(recording, replayed))
    for line in _lines(recording, replayed, found):
        print(line)
    _summarize(title, replayed, found)


def _lines(recording: Recording, replayed: Replayed, found: Sequence[TriedCommand]) -> Iterator[str]:
    """Yield the commands and the messages to people in order of time, and then the hints."""
    start, names = recording.header.started_at.to_seconds(), part_names(replayed.devices)
    lines = [
        (one.time.timestamp(), f"{_stamp(one.time)}  told people: {printable(one.text)}  {one.app}")
        for one in replayed.notifications
    ]
    for one in found:
        later = f"; {age_text(one.seconds)} later somebody: {printable(one.change)}" if one.change else ""
        lines.append((start + one.given.at, f"{command_text(one.given, start, names)}{later}"))
    yield from (line for _, line in sorted(lines))
    for name, hints in replayed.hints.items():
        yield from (f"{printable(name)}: {printable(hint, 500)}" for hint in hints)


def _stamp(at: datetime) -> str:
    return f"{at.astimezone():%Y-%m-%d %H:%M:%S}"


def _summarize(path: str, replayed: Replayed, found: Sequence[TriedCommand]) -> None:
    commands = Counter(one.given.command.issuer for one in found)
    changed = Counter(one.given.command.issuer for one in found if one.change)
    for issuer in replayed.issuers:
        count, against = commands[issuer], changed[issuer]
        given = "1 command" if count == 1 else f"{count:,} commands"
        note = f", {against:,} of which somebody changed within ten minutes" if against else ""
        print(f"{printable(path)}: {issuer.removeprefix('/')} would have given {given}{note}")
