"""The lines of ``homebot why`` and ``why-not`` about routines: those that sent a robot, and those held back."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import suppress
from typing import TYPE_CHECKING, Final, cast

from homebot.cli.device_queries import house_time
from homebot.cli.door_client import DoorClient
from homebot.devices.names import LIST_ROUTINES
from homebot.devices.wording.journal_words import ago_text
from homebot.devices.wording.json_message import JsonMessage
from homebot.devices.wording.time_format import to_seconds
from homebot.errors import PeerError
from homebot.support.printable import printable
from homebot.words.phrases import DRIVE_VERBS

if TYPE_CHECKING:
    from homebot.devices.app_messages import RoutinesResponse

_MAX_SENT: Final = 10
_MAX_TEXT: Final = 300


def sent_robot(door: DoorClient, robot: str) -> Iterator[str]:
    """Yield the outcomes of the last steps of routines that sent *robot*, oldest first."""
    steps = [f"{quote}{robot} {verb} to ".casefold() for quote in "'\"" for verb in DRIVE_VERBS]
    with suppress(PeerError):  # an older homebot has none
        routines = cast("RoutinesResponse", JsonMessage(door.call(LIST_ROUTINES, {}))).routines
        sent = [
            (note, routine.name)
            for routine in routines
            for note in routine.notes
            if any(step in note.text.casefold() for step in steps)
        ]
        for note, name in sorted(sent, key=lambda row: to_seconds(row[0].at))[-_MAX_SENT:]:
            ago = ago_text(note.at, house_time(door))
            yield f"The routine {printable(name)}: {printable(note.text, _MAX_TEXT)}, {ago}."


def held_back(door: DoorClient, device: str) -> Iterator[str]:
    """Yield which routines for *device* are switched off, or were held back by a condition the last time."""
    with suppress(PeerError):  # as above
        for routine in cast("RoutinesResponse", JsonMessage(door.call(LIST_ROUTINES, {"device": device}))).routines:
            name, note = printable(routine.name), routine.notes[-1] if routine.notes else None
            if not routine.enabled:
                yield f"The routine {name} is disabled: homebot routine enable {shlex.quote(name)}"
            elif note is not None and note.text.startswith("held back"):
                ago = ago_text(note.at, house_time(door))
                yield f"The routine {name} was {printable(note.text, _MAX_TEXT)}, {ago}."
