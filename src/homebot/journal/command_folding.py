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
"""Steps of a command other than its request and its outcome."""

MOST_OF_ISSUER: Final = 1000
"""Commands of one issuer that are stored in each minute; further ones are folded as if all were to one part."""

_MINUTE: Final = 60.0
_MOST_MINUTES: Final = 10_000

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
    issuer and part are counted.
    """

    def __init__(self) -> None:
        self._minutes: dict[_Key, _Minute] = {}
        self._first: _Minute | None = None
        self._stored: defaultdict[str, int] = defaultdict(int)  # by issuer, in the current minute
        self._counted_since = 0.0

    def add(self, notes: Sequence[JournalNote]) -> Sequence[JournalNote]:
        """Return the entries to store after *notes*: those of one command, or one other entry."""
        first, last = notes[0], notes[-1]
        if first.kind in _STEPS and last.kind in _STEPS:  # of a stored command
            return notes
        ended = tuple(self._ended(last.at))
        is_bounded = not first.issuer or (first.kind == "denied" and not first.settings)  # as for denials of the door
        return (*ended, *(notes if is_bounded else self._limited(notes)))

    def waiting(self) -> list[JournalNote]:
        """Return the entries that are not stored yet."""
        return [note for minute in self._minutes.values() for notes in minute.folded.values() for note in notes]

    def _limited(self, notes: Sequence[JournalNote]) -> Sequence[JournalNote]:
        first, last = notes[0], notes[-1]
        if not 0 <= last.at - self._counted_since < _MINUTE:
            self._counted_since = last.at
            self._stored.clear()
        key = first.issuer, first.device, first.part
        if self._stored[first.issuer] >= MOST_OF_ISSUER:  # the named devices may not exist
            key = first.issuer, "", ""
        minute = self._minutes.get(key)
        if minute is None:
            minute = self._minutes[key] = _Minute(last.at)
            self._first = self._first or minute
        if minute.stored >= IN_FULL:
            return () if minute.fold(_outcome(last), list(notes)) else notes
        minute.stored += 1
        self._stored[first.issuer] += 1
        minute.outcomes.add(_outcome(last))
        return notes

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
    return f"refused {outcome.policy}" if isinstance(outcome, Refused) else outcome.kind if outcome else note.kind
