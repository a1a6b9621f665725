"""Entries of the journal in memory, where nothing is kept over a restart."""

from __future__ import annotations

from collections import Counter, deque
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import final

from homebot.control.journal.journal_note import JournalNote
from homebot.control.journal.learnt_row import LearntRow
from homebot.devices.journal_messages import MOST_ENTRIES, ReadJournalRequest, ReadJournalResponse
from homebot.messages import Time

__all__ = ["MemoryStore", "with_newer"]

_SHARE = 0.1
"""Of the entries of the issuer with the most, that are dropped at once; see :mod:`.journal_file`."""


@final
class MemoryStore:
    """The newest entries; the oldest are dropped when they are too old, those of the largest issuer when too many.

    Args:
        most: How many are kept.
        longest: Seconds for which an entry is kept.

    Attributes:
        dropped: Entries that were dropped.
        failures: Entries that could not be kept; always 0.
        problem: The trouble of the store, as text; always empty.
    """

    def __init__(self, most: int, longest: float) -> None:
        self._entries: deque[JournalNote] = deque()
        self._most = most
        self._longest = longest
        self.dropped = 0
        self.failures = 0
        self.problem = ""
        self.remembers = False

    def add(self, note: JournalNote) -> None:
        """Keep what was noted."""
        entries = self._entries
        entries.append(note)
        oldest = note.at - self._longest
        while entries[0].at < oldest:
            entries.popleft()
            self.dropped += 1
        if len(entries) > self._most:
            self._drop_oldest()

    def _drop_oldest(self) -> None:
        """Drop the oldest entries of the issuer with the most."""
        ((issuer, count),) = Counter(note.issuer for note in self._entries).most_common(1)
        excess = max(1, round(_SHARE * count))
        self.dropped += excess
        kept: deque[JournalNote] = deque()
        for note in self._entries:
            if excess and note.issuer == issuer:
                excess -= 1
            else:
                kept.append(note)
        self._entries = kept

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit."""
        limit = min(request.limit or MOST_ENTRIES, MOST_ENTRIES)
        found = list(islice(_newest_fitting(self._entries, request), limit + 1))
        return ReadJournalResponse(
            entries=tuple([note.entry() for note in reversed(found[:limit])]),
            complete=len(found) <= limit,
            begins=self._entries[0].stamp if self._entries else Time(sec=0, nanosec=0),
        )

    def learn(self, row: LearntRow) -> None:
        """Do nothing: what was learnt ends with the run."""

    async def learnt(self) -> tuple[LearntRow, ...]:
        """Return nothing: no earlier run is known."""
        return ()

    async def run(self) -> None:
        """Do nothing: there is no file."""

    async def close(self) -> None:
        """Do nothing, as above."""


def with_newer(
    response: ReadJournalResponse, notes: Sequence[JournalNote], request: ReadJournalRequest
) -> ReadJournalResponse:
    """Return *response* with those of the newer *notes*, oldest first, that fit *request*."""
    if not notes or not response.success:
        return response
    limit = min(request.limit or MOST_ENTRIES, MOST_ENTRIES)
    newer = list(islice(_newest_fitting(notes, request), limit + 1))
    entries = (*response.entries, *(note.entry() for note in reversed(newer)))
    begins = response.begins if response.begins.to_seconds() else notes[0].stamp
    is_complete = response.complete and len(entries) <= limit
    return ReadJournalResponse(entries=entries[-limit:], complete=is_complete, begins=begins)


def _newest_fitting(notes: Sequence[JournalNote], request: ReadJournalRequest) -> Iterator[JournalNote]:
    """Yield those of *notes*, oldest first as they are, that fit *request*, newest first."""
    since, until = request.since.to_seconds(), request.until.to_seconds()
    for note in reversed(notes):
        at = note.stamp.to_seconds()  # who asks has it from an entry
        if at < since:
            continue  # not the end: the clock may have been set
        if (not until or at <= until) and request.device in {"", note.device} and request.command in {"", note.command}:
            yield note
