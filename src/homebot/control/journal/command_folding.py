"""Folding of equal commands of one issuer to one part: the newest of each minute, and their number. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

from homebot.control.journal.store import JournalNote

__all__ = ["IN_FULL", "CommandFolding"]

IN_FULL: Final = 10
"""Commands of one issuer to one part in each minute that are stored regardless of their outcome."""

_MINUTE: Final = 60.0
_MOST_MINUTES: Final = 10_000
_MOST_OPEN: Final = 1000

_Key: TypeAlias = tuple[str, str, str]
"""Issuer, and the ids of the device and its part."""


@dataclass(slots=True)
class _Minute:
    """The commands of one issuer to one part in a minute.

    Attributes:
        began: Time of the first, in seconds since the Unix epoch.
        stored: The number of stored commands.
        outcomes: The outcomes among them.
        folded: The entries of the newest folded command for each outcome; the first has the number of the others.
    """

    began: float
    stored: int = 0
    outcomes: set[str] = field(default_factory=set)
    folded: dict[str, list[JournalNote]] = field(default_factory=dict)

    def fold(self, outcome: str, notes: list[JournalNote]) -> bool:
        """Replace the earlier command with the same *outcome* by *notes*; False if it is the first."""
        if outcome not in self.outcomes:
            self.outcomes.add(outcome)
            return False
        if (before := self.folded.pop(outcome, None)) is not None:
            notes[0].folded = before[0].folded + 1
        self.folded[outcome] = notes
        return True


@final
class CommandFolding:
    """Filter in front of the store: a flood of equal commands leaves a few entries a minute.

    An entry without an issuer passes. At most 10,000 pairs of issuer and part are counted in a minute, and 1,000
    commands wait for their outcome; beyond that the oldest are stored.
    """

    def __init__(self) -> None:
        self._minutes: dict[_Key, _Minute] = {}
        self._open: dict[str, list[JournalNote]] = {}

    def add(self, note: JournalNote) -> list[JournalNote]:
        """Return the entries to store after *note*."""
        stored = list(self._ended(note.at))
        if note.command in self._open:
            stored += self._continue(note)
        elif note.issuer and (note.kind != "denied" or note.settings):  # denials of the door are bounded already
            stored += self._begin(note)
        else:
            stored.append(note)
        return stored

    def waiting(self) -> list[JournalNote]:
        """Return the entries that are not stored yet, oldest first."""
        folded = [notes for minute in self._minutes.values() for notes in minute.folded.values()]
        return sorted((note for notes in (*folded, *self._open.values()) for note in notes), key=lambda note: note.at)

    def close(self) -> list[JournalNote]:
        """Return the rest of the entries to store."""
        left = self.waiting()
        self._minutes.clear()
        self._open.clear()
        return left

    def _begin(self, note: JournalNote) -> Iterable[JournalNote]:
        minute = self._minutes.setdefault((note.issuer, note.device, note.part), _Minute(note.at))
        if note.command and note.kind not in {"requested", "published"}:  # a step of a stored command
            if note.kind == "outcome":
                minute.outcomes.add(_outcome(note))
            return (note,)
        if minute.stored < IN_FULL:
            minute.stored += 1
            if note.kind != "requested":
                minute.outcomes.add(note.kind)
            return (note,)
        if note.kind != "requested":
            return () if minute.fold(note.kind, [note]) else (note,)
        self._open[note.command] = [note]
        return self._open.pop(next(iter(self._open))) if len(self._open) > _MOST_OPEN else ()

    def _continue(self, note: JournalNote) -> Iterable[JournalNote]:
        notes = self._open[note.command]
        notes.append(note)
        if note.kind != "outcome":
            return ()
        del self._open[note.command]
        minute = self._minutes.get((note.issuer, note.device, note.part))
        return () if minute is not None and minute.fold(_outcome(note), notes) else notes

    def _ended(self, now: float) -> Iterator[JournalNote]:
        """Remove the ended minutes, and yield their folded entries."""
        while self._minutes:
            key, first = next(iter(self._minutes.items()))
            if 0 <= now - first.began < _MINUTE and len(self._minutes) < _MOST_MINUTES:
                return
            del self._minutes[key]
            for notes in first.folded.values():
                yield from notes


def _outcome(note: JournalNote) -> str:
    return f"{note.results[0].outcome} {note.results[0].policy}"
