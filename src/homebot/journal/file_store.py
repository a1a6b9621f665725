"""Store of the journal and the device profiles in a file.

A worker thread writes two minutes' worth at a time.
"""

from collections import deque
from contextlib import suppress
from itertools import islice
from pathlib import Path
from typing import Final, final

import anyio
from anyio import to_thread

from homebot.devices.journal_messages import ReadJournalRequest, ReadJournalResponse
from homebot.errors import LinkError
from homebot.graph import Node
from homebot.journal.journal_file import JournalFile
from homebot.journal.store import JournalNote, JournalStore, LearntRow, with_newer
from homebot.log import LogLimit
from homebot.support.managed_file import ManagedFile

_WRITE_AFTER: Final = 120.0
"""Seconds for which entries are gathered, and which a power cut loses: each write costs whole blocks, which wear out an
SD card."""

_MANY: Final = 1000
"""Entries, or rows, that are written in one batch."""

_RETRY_AFTER: Final = 5.0
_LAST_CHANCE: Final = 5.0
_BATCH: Final = 2000
_MAX_WAITING: Final = 10_000
"""Entries, and rows, that may wait for the disk; beyond this the oldest are lost and counted."""


@final
class FileStore(JournalStore):
    """Entries in an SQLite file, bounded by age and size, the oldest dropped first.

    The file is opened at the first entry or question, so a home without commands has none. If another homebot uses it,
    or a newer one wrote it, entries are in memory only. If it is deleted, a new one is created.

    Args:
        longest: Seconds for which an entry is stored.
        most_in_memory: The largest number of entries if the file cannot be used.
    """

    def __init__(
        self,
        node: Node,
        path: Path,
        longest: float,
        most_bytes: float,
        most_in_memory: int,
        most_waiting: int = _MAX_WAITING,
    ) -> None:
        super().__init__(most_in_memory, longest)
        self._clock = clock = node.graph.clock
        self._most_bytes = most_bytes
        self._most_waiting = most_waiting
        self._kept = ManagedFile(
            JournalFile(path),
            "the journal",
            "the journal is in memory only",
            node.log,
            clock.now,
            LogLimit(clock).allows,
            on_end=self._use_memory,
        )
        self._kept.file.write_rest = self._write
        self._waiting: deque[JournalNote] = deque()
        self._learnt: dict[tuple[str, str], LearntRow] = {}
        self._has_news, self._has_many = anyio.Event(), anyio.Event()
        self._overrun = 0
        self.remembers = True

    @property
    def problem(self) -> str:
        """The problem with the file, as text; empty if there is none."""
        return self._kept.trouble

    def add(self, note: JournalNote) -> None:
        """Add an entry; it is written within two minutes."""
        if self._kept.is_unusable:
            super().add(note)
            return
        self._waiting.append(note)
        if len(self._waiting) > self._most_waiting:
            self._waiting.popleft()
            self._overrun += 1
            self.failures += 1
        self._wake()

    def learn(self, row: LearntRow) -> None:
        """Replace a row; it is written within two minutes, or lost without a file."""
        if self._kept.is_unusable:
            return
        self._learnt[row.kind, row.name] = row
        if len(self._learnt) > self._most_waiting:
            del self._learnt[next(iter(self._learnt))]
            self.failures += 1
        self._wake()

    def _wake(self) -> None:
        self._has_news.set()
        if max(len(self._waiting), len(self._learnt)) >= _MANY:
            self._has_many.set()

    async def learnt(self) -> tuple[LearntRow, ...]:
        """Return the rows of earlier runs; none if the file cannot be read."""
        with suppress(LinkError):
            async with self._kept.opened() as file:
                return await to_thread.run_sync(file.read_learnt)
        return ()

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit, including unwritten ones."""
        await self._write()
        if self._kept.is_unusable:
            return await super().read(request)
        try:
            async with self._kept.opened() as file:
                response = await to_thread.run_sync(file.read_entries, request)
                return with_newer(response, self._waiting, request)
        except LinkError as exc:
            return ReadJournalResponse(success=False, message=str(exc))

    async def run(self) -> None:
        """Write until cancelled."""
        while True:
            await self._has_news.wait()
            if not self._kept.problem:
                with anyio.move_on_after(_WRITE_AFTER):
                    await self._has_many.wait()
            else:
                await anyio.sleep(_RETRY_AFTER)
            self._has_news, self._has_many = anyio.Event(), anyio.Event()
            await self._write()
            if self._waiting or self._learnt:
                self._has_news.set()

    async def close(self) -> None:
        """Write the rest and close the file, within five seconds, even when cancelled."""
        with anyio.move_on_after(_LAST_CHANCE, shield=True):
            await self._write()
            await self._kept.close()

    async def _write(self) -> None:
        with suppress(LinkError):
            while (self._waiting or self._learnt) and not self._kept.is_unusable:
                async with self._kept.opened(writes=True) as file:
                    oldest, batch = self._clock.now() - self._longest, tuple(islice(self._waiting, _BATCH))
                    before, learnt = self._overrun, tuple(self._learnt.values())
                    self.dropped += await to_thread.run_sync(file.write, batch, learnt, oldest, self._most_bytes)
                    for row in learnt:
                        if self._learnt.get((row.kind, row.name)) is row:
                            del self._learnt[row.kind, row.name]
                    for _ in range(len(batch) - (self._overrun - before)):  # except entries that were lost meanwhile
                        self._waiting.popleft()

    def _use_memory(self) -> None:
        for note in self._waiting:
            super().add(note)
        self._waiting.clear()
        self._learnt.clear()
