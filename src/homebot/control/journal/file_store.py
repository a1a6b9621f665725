"""Store of the journal and of device profiles in a file.

Written by a worker thread, two minutes' worth at a time.
"""

from __future__ import annotations

from collections import deque
from itertools import islice
from pathlib import Path
from typing import Final, final

import anyio
from anyio import to_thread

from homebot.control.journal.journal_file import JournalFile
from homebot.control.journal.store import JournalNote, JournalStore, LearntRow, with_newer
from homebot.devices.journal_messages import ReadJournalRequest, ReadJournalResponse
from homebot.errors import LinkError, UsageError, WireError
from homebot.graph import Node
from homebot.log import LogLimit

__all__ = ["FileStore"]

NOT_WRITTEN = "control.journal_not_written"
NOT_USED = "control.journal_not_used"
DAMAGED = "control.journal_damaged"
REMOVED = "control.journal_removed"

_WRITE_AFTER: Final = 120.0
"""Seconds in which entries are gathered, which a power cut loses: a disk writes whole blocks each time, and an SD card
wears out by them."""

_MANY: Final = 1000
"""Entries, or rows, that are written at once."""

_RETRY_AFTER: Final = 5.0
_LAST_CHANCE: Final = 5.0
_BATCH: Final = 2000
_MOST_WAITING: Final = 10_000
"""Entries, and rows, that wait for the disk; more are lost, the oldest first, and counted."""


@final
class FileStore(JournalStore):
    """Entries in an SQLite file, bounded by age and size, the oldest dropped first.

    It is opened at the first entry or question, so that a home without commands has none. If another homebot uses it,
    or a newer one wrote it, entries are in memory only. If it is removed, a new one is made.

    Args:
        longest: Seconds for which an entry is stored.
        most_bytes: The size of all entries at most.
        most_in_memory: The number of entries at most if the file cannot be used.
        most_waiting: The number of entries, and of rows, at most that wait to be written.

    Attributes:
        problem: The trouble of the file, as text; empty if there is none. A removal stays one.
    """

    def __init__(
        self,
        node: Node,
        path: Path,
        longest: float,
        most_bytes: float,
        most_in_memory: int,
        most_waiting: int = _MOST_WAITING,
    ) -> None:
        super().__init__(most_in_memory, longest)
        self._node = node
        self._clock = node.graph.clock
        self._path = path
        self._most_bytes = most_bytes
        self._most_waiting = most_waiting
        self._file = JournalFile(path)
        self._file.write_rest = self._write
        self._waiting: deque[JournalNote] = deque()
        self._learnt: dict[tuple[str, str], LearntRow] = {}
        self._has_news, self._has_many = anyio.Event(), anyio.Event()
        self._turn = anyio.Lock()
        self._limit = LogLimit(self._clock)
        self._is_unusable = False
        self._loss = ""
        self._overrun = 0
        self.remembers = True

    def add(self, note: JournalNote) -> None:
        """Add an entry; it is written within two minutes."""
        if self._is_unusable:
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
        if self._is_unusable:
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
        async with self._turn:
            file = None if self._is_unusable else await self._opened()
            if file is None:
                return ()
            try:
                return await to_thread.run_sync(file.read_learnt)
            except (LinkError, WireError) as exc:
                self._record_failure(exc)
                return ()

    async def read(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit, also unwritten ones."""
        await self._write()
        if self._is_unusable:
            return await super().read(request)
        async with self._turn:
            file = await self._opened()
            if file is None:
                return ReadJournalResponse(success=False, message=self.problem)
            try:
                response = await to_thread.run_sync(file.read_entries, request)
            except (LinkError, WireError) as exc:
                self._record_failure(exc)
                return ReadJournalResponse(success=False, message=str(exc))
            return with_newer(response, self._waiting, request)

    async def run(self) -> None:
        """Write until cancelled."""
        while True:
            await self._has_news.wait()
            if self.problem == self._loss:
                with anyio.move_on_after(_WRITE_AFTER):
                    await self._has_many.wait()
            else:
                await anyio.sleep(_RETRY_AFTER)
            self._has_news, self._has_many = anyio.Event(), anyio.Event()
            await self._write()
            if self._waiting or self._learnt:
                self._has_news.set()

    async def close(self) -> None:
        """Write the rest and close the file, within five seconds, cancelled or not."""
        with anyio.move_on_after(_LAST_CHANCE, shield=True):
            await self._write()
            await to_thread.run_sync(self._file.close)

    async def _write(self) -> None:
        async with self._turn:
            while (self._waiting or self._learnt) and not self._is_unusable:
                file = await self._opened()
                if file is None or not await self._write_batch(file):
                    return

    async def _write_batch(self, file: JournalFile) -> bool:
        oldest, batch = self._clock.now() - self._longest, tuple(islice(self._waiting, _BATCH))
        before, learnt = self._overrun, tuple(self._learnt.values())
        try:
            self.dropped += await to_thread.run_sync(file.write, batch, learnt, oldest, self._most_bytes)
        except WireError as exc:
            self._record_failure(exc)
            await self._set_aside()
            return False
        except LinkError as exc:
            self._record_failure(exc)
            return False
        self.problem = self._loss
        for row in learnt:
            if self._learnt.get((row.kind, row.name)) is row:
                del self._learnt[row.kind, row.name]
        for _ in range(len(batch) - (self._overrun - before)):  # without the entries that were lost meanwhile
            self._waiting.popleft()
        return True

    async def _opened(self) -> JournalFile | None:
        """Return the open file; None if it cannot be used now."""
        if self._file.is_open:
            if not await to_thread.run_sync(self._file.is_lost):
                return self._file
            await self._begin_anew()
        try:
            damaged = await to_thread.run_sync(self._file.open, self._clock.now())
        except UsageError as exc:
            self._use_memory(str(exc))
            return None
        except LinkError as exc:
            self._record_failure(exc)
            return None
        if damaged is not None:
            self._log_damage(damaged)
        return self._file

    async def _begin_anew(self) -> None:
        """Close a removed file."""
        await to_thread.run_sync(self._file.close)
        self.problem = self._loss = (
            f"the journal {self._path} was removed or replaced while homebot ran, and what it had is lost; "
            "stop homebot before you move it"
        )
        self._node.log.warning(REMOVED, message=f"{self._loss}; a new one is begun", file=str(self._path))

    async def _set_aside(self) -> None:
        """Move a damaged file away; the next write begins a new one."""
        try:
            self._log_damage(await to_thread.run_sync(self._file.set_aside, self._clock.now()))
        except OSError as exc:
            self._use_memory(f"the journal {self._path} cannot be set aside: {exc}")

    def _use_memory(self, why: str) -> None:
        self._is_unusable, self.problem = True, why
        self._node.log.warning(
            NOT_USED, message=f"{why}; until the next start the journal is in memory alone", file=str(self._path)
        )
        for note in self._waiting:
            super().add(note)
        self._waiting.clear()
        self._learnt.clear()

    def _record_failure(self, exc: LinkError | WireError) -> None:
        self.problem = str(exc)
        held_back = self._limit.allows(NOT_WRITTEN)
        if held_back is not None:
            self._node.log.warning(NOT_WRITTEN, message=f"{exc}; trying again", held_back=held_back)

    def _log_damage(self, where: Path) -> None:
        self._node.log.warning(
            DAMAGED, message=f"the journal was damaged; it was moved to {where}, and a new one is used", file=str(where)
        )
