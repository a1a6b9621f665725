"""Folding of equal commands of one issuer to one part: the newest of each minute, with their count. Pure."""

from collections.abc import Sequence
from typing import Final, TypeAlias, final

from homebot.devices.outcomes import Refused
from homebot.journal.store import JournalNote
from homebot.support.limits import Limiter, LimitInterval

IN_FULL: Final = 10
"""Equal commands of one issuer to one part in each minute that are stored in full."""

_STEPS: Final = frozenset({"judged", "sent", "acknowledged", "reported", "reverted", "would"})
"""Steps of a command other than its request and its outcome."""

MAX_OF_ISSUER: Final = 1000
"""Commands of one issuer that are stored in each minute; further ones are folded as if all were to one part."""

_MINUTE: Final = 60.0
_MAX_COUNTED: Final = 30_000
"""Issuers, their parts, and the outcomes there."""

_Notes: TypeAlias = list[JournalNote]


@final
class EntryAggregation:
    """Filter in front of the store: a flood of equal commands becomes a few entries a minute.

    An entry without an issuer passes. At most 1,000 commands of one issuer are stored in a minute.
    """

    def __init__(self) -> None:
        self._counted = Limiter[tuple[str, ...], _Notes](_MINUTE, _MAX_COUNTED, self._on_interval_end)
        self._ended: _Notes = []

    def add(self, notes: Sequence[JournalNote]) -> Sequence[JournalNote]:
        """Return the entries to store after *notes*: those of one command, or one other entry."""
        first, last = notes[0], notes[-1]
        if first.kind in _STEPS and last.kind in _STEPS:  # of a stored command
            return notes
        is_bounded = not first.issuer or (first.kind == "denied" and not first.settings)  # as for denials of the door
        stored = notes if is_bounded or self._passes(notes) else ()
        self._counted.drop(last.at)
        ended, self._ended = self._ended, []
        return (*ended, *stored)

    def waiting(self) -> list[JournalNote]:
        """Return the entries that are not stored yet."""
        return [note for counted in self._counted.values() for note in _fold_notes(counted.newest, counted.held_back)]

    def _passes(self, notes: Sequence[JournalNote]) -> bool:
        """Return whether to store *notes*; if not, they take the place of the command before with the same outcome."""
        first, last, of = notes[0], notes[-1], self._counted.of
        issuer = of((first.issuer,), last.at)
        is_flood = issuer.passed >= MAX_OF_ISSUER  # the named devices may not exist
        key = (first.issuer, "", "") if is_flood else (first.issuer, first.device, first.part)
        part = of(key, last.at)
        if part.passed >= IN_FULL - 1 and not of((*key, _outcome(last)), last.at).admit(1, list(notes)):
            return False
        issuer.passed += 1
        part.passed += 1
        return True

    def _on_interval_end(self, _key: object, interval: LimitInterval[_Notes]) -> None:
        self._ended += _fold_notes(*interval.release())


def _fold_notes(notes: _Notes | None, count: int) -> _Notes:
    """Return the newest of *count* folded commands; its first entry counts the others."""
    return [notes[0]._replace(folded=count - 1), *notes[1:]] if notes else []


def _outcome(note: JournalNote) -> str:
    outcome = note.outcome
    return f"refused {outcome.policy}" if isinstance(outcome, Refused) else outcome.kind if outcome else note.kind
