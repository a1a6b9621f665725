"""Port of the stores of the journal, which keep what was learnt from commands too."""

from __future__ import annotations

from typing import Protocol

from homebot.control.journal.journal_note import JournalNote
from homebot.control.journal.learnt_row import LearntRow
from homebot.devices.journal_messages import ReadJournalRequest, ReadJournalResponse

__all__ = ["JournalStore"]


class JournalStore(Protocol):
    """Keeps entries in the order in which they come.

    Attributes:
        dropped: Entries that were dropped because they were too many or too old.
        failures: Entries that could not be kept.
        problem: The trouble of the store, as text; empty where there is none.
        remembers: Whether it may have what an earlier run learnt.
    """

    dropped: int
    failures: int
    problem: str
    remembers: bool

    def add(self, note: JournalNote) -> None:
        """Keep what was noted; never blocks, and does no input or output."""
        ...

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit, also those that were added a moment ago."""
        ...

    def learn(self, row: LearntRow) -> None:
        """Keep *row* in place of the one of its kind and name; without a record, none; never blocks."""
        ...

    async def learnt(self) -> tuple[LearntRow, ...]:
        """Return what an earlier run learnt, the longest unused first; a row that cannot be read has no record."""
        ...

    async def run(self) -> None:
        """Write what is added until cancelled."""
        ...

    async def close(self) -> None:
        """Write what waits and close, within a few seconds; nothing is added afterwards."""
        ...
