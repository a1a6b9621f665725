"""A store for tests of what is known after a restart."""

from __future__ import annotations

from homebot.control.journal.store import JournalNote, LearntRow, MemoryStore
from homebot.devices.journal_messages import ReadJournalRequest, ReadJournalResponse

__all__ = ["KeptStore"]


class KeptStore:
    """A store of which what was learnt outlives a restart, without a file and its thread."""

    def __init__(self) -> None:
        self._entries = MemoryStore(1000, 86_400.0)
        self.rows: dict[tuple[str, str], LearntRow] = {}
        self.dropped, self.failures, self.problem, self.remembers = 0, 0, "", True

    def add(self, note: JournalNote) -> None:
        self._entries.add(note)

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        return await self._entries.read(request)

    def learn(self, row: LearntRow) -> None:
        self.rows[row.kind, row.name] = row
        if not row.record:
            del self.rows[row.kind, row.name]

    async def learnt(self) -> tuple[LearntRow, ...]:
        return tuple(self.rows.values())

    async def run(self) -> None:
        """Do nothing: there is no file."""

    async def close(self) -> None:
        """Do nothing: the next run goes on with it."""
