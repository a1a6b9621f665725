"""``homebot routine try``: prints what routines would have done on recorded days."""

import argparse
import asyncio
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from homebot.cli.commands.replay import command_text
from homebot.config import load_config
from homebot.devices.device import part_names
from homebot.devices.wording.time_format import age_text
from homebot.errors import UsageError
from homebot.log import configure_logging
from homebot.recording.recording import load_recording
from homebot.replay.replay import Replayed, replay
from homebot.replay.routine_trial import TriedCommand, trial_config, tried
from homebot.support.printable import printable
from homebot.support.virtual_time import VirtualTimeLoop

__all__ = ["try_routines"]


def try_routines(options: argparse.Namespace) -> int:
    """Replay each recording with the routines of the file, and print their commands; nothing is sent."""
    configure_logging(level="critical")
    given = load_config(Path(options.file))
    for path in options.on:
        recording = load_recording(Path(path))
        config = trial_config(recording, given)
        with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
            loop = runner.get_loop()
            assert isinstance(loop, VirtualTimeLoop)  # noqa: S101 - for the type checker: it was made the line before
            replayed = runner.run(replay(recording, config, loop.settled))
        if replayed.crashes:
            name, error = next(iter(replayed.crashes.items()))
            raise UsageError(f"{name} crashed: {error}")
        found = tuple(tried(recording, replayed))
        start, names = recording.header.started_at.to_seconds(), part_names(replayed.devices)
        for one in found:
            later = f"; {age_text(one.seconds)} later somebody: {printable(one.change)}" if one.change else ""
            print(f"{command_text(one.given, start, names)}{later}")
        _summarize(path, replayed, found)
    return 0


def _summarize(path: str, replayed: Replayed, found: Sequence[TriedCommand]) -> None:
    commands = Counter(one.given.command.issuer for one in found)
    changed = Counter(one.given.command.issuer for one in found if one.change)
    for issuer in replayed.issuers:
        count, against = commands[issuer], changed[issuer]
        given = "1 command" if count == 1 else f"{count:,} commands"
        note = f", {against:,} of which somebody changed within ten minutes" if against else ""
        print(f"{printable(path)}: {issuer.removeprefix('/')} would have given {given}{note}")
