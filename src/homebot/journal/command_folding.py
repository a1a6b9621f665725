"""Folding of equal commands of one issuer to one part: the newest of each minute, with their count. Pure."""

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, TypeAlias, final

from homebot.devices.outcomes import Refused
from homebot.journal.store import JournalNote

__all__ = ["IN_FULL", "MOST_OF_ISSUER", "CommandFolding"]

IN_FULL: Final = 10
"""Commands of one issuer to one part in each minute that are stored regardless of their outcome."""

_STEPS: Final = frozenset({"judged", "sent", "acknowledged", "reported", "reverted", "would"})
"""Steps between a command and its outcome, or after the outcome."""

MOST_OF_ISSUER: Final = 1000
"""Commands of one issuer that are stored in each minute; further ones are folded as if all were to one part."""

_MINUTE: Final = 60.0
_MOST_MINUTES: Final = 10_000
_MOST_OPEN: Final = 1000

_Key: TypeAlias = tuple[str, str, str]
"""Issuer, and the ids of the device and its part."""


@dataclass(slots=True)
class _Minute:
    """The commands of one issuer to one part in a minute.

    Attributes:
        began: Time of the first command, in seconds since the Unix epoch.
        folded: The entries of the newest folded command for each outcome; the first entry counts the others.
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
            notes[0] = notes[0]._replace(folded=before[0].folded + 1)
        self.folded[outcome] = notes
        return True


@final
class CommandFolding:
    """Filter in front of the store: a flood of equal commands becomes a few entries a minute.

    An entry without an issuer passes. At most 1,000 commands of one issuer are stored in a minute, and 10,000 pairs of
    issuer and part are counted. At most 1,000 commands wait for their outcome; the oldest beyond these are stored.
    """

    def __init__(self) -> None:
        self._minutes: dict[_Key, _Minute] = {}
        self._open: dict[str, list[JournalNote]] = {}
        self._first: _Minute | None = None
        self._stored: defaultdict[str, int] = defaultdict(int)  # by issuer, in the current minute
        self._counted_since = 0.0

    def add(self, note: JournalNote) -> Sequence[JournalNote]:
        """Return the entries to store after *note*."""
        if note.command in self._open:
            return self._continue(note)
        if note.kind in _STEPS:  # of a stored command
            return (note,)
        ended = tuple(self._ended(note.at))
        is_bounded = not note.issuer or (note.kind == "denied" and not note.settings)  # as for denials of the door
        stored = (note,) if is_bounded else self._begin(note)
        return (*ended, *stored) if ended else stored

    def waiting(self) -> list[JournalNote]:
        """Return the entries that are not stored yet, oldest first."""
        folded = [notes for minute in self._minutes.values() for notes in minute.folded.values()]
        return sorted((note for notes in (*folded, *self._open.values()) for note in notes), key=lambda note: note.at)

    def close(self) -> list[JournalNote]:
        """Return the rest of the entries to store."""
        left = self.waiting()
        self._minutes.clear()
        self._first = None
        self._open.clear()
        return left

    def _begin(self, note: JournalNote) -> Sequence[JournalNote]:
        if not 0 <= note.at - self._counted_since < _MINUTE:
            self._counted_since = note.at
            self._stored.clear()
        key = note.issuer, note.device, note.part
        if self._stored[note.issuer] >= MOST_OF_ISSUER:  # the named devices may not exist
            key = note.issuer, "", ""
        minute = self._minutes.get(key)
        if minute is None:
            minute = self._minutes[key] = _Minute(note.at)
            self._first = self._first or minute
        if note.kind == "outcome":  # of a stored command
            minute.outcomes.add(_outcome(note))
            return (note,)
        if minute.stored < IN_FULL:
            minute.stored += 1
            self._stored[note.issuer] += 1
            minute.outcomes.add(note.kind)
            return (note,)
        if note.kind != "requested":
            return () if minute.fold(note.kind, [note]) else (note,)
        self._open[note.command] = [note]
        return self._open.pop(next(iter(self._open))) if len(self._open) > _MOST_OPEN else ()

    def _continue(self, note: JournalNote) -> Sequence[JournalNote]:
        notes = self._open[note.command]
        notes.append(note)
        if note.kind != "outcome":
            return ()
        del self._open[note.command]
        is_over = self._stored[note.issuer] >= MOST_OF_ISSUER
        minute = self._minutes.get((note.issuer, "", "") if is_over else (note.issuer, note.device, note.part))
        return () if minute is not None and minute.fold(_outcome(note), notes) else notes

    def _ended(self, now: float) -> Iterator[JournalNote]:
        """Remove the ended minutes, and the oldest if there are too many; yield their folded entries."""
        while (first := self._first) is not None:
            if 0 <= now - first.began < _MINUTE and len(self._minutes) < _MOST_MINUTES:
                return
            del self._minutes[next(iter(self._minutes))]
            self._first = next(iter(self._minutes.values()), None)
            for notes in first.folded.values():
                yield from notes


def _outcome(note: JournalNote) -> str:
    outcome = note.outcome
    return f"refused {outcome.policy}" if isinstance(outcome, Refused) else outcome.kind if outcome else ""
