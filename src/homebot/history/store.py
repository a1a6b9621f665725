"""The history's file, written and read by worker threads, one at a time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Final, TypeVar, final

import anyio
from anyio import to_thread

from homebot.errors import LinkError, UsageError, WireError
from homebot.graph import Node
from homebot.history.collector import Collector
from homebot.history.history_file import HistoryFile, StoredSeries
from homebot.history.reading import HistoryReader
from homebot.history.settings import HistorySettings
from homebot.log import LogLimit

__all__ = ["HistoryStore"]

T = TypeVar("T")

NOT_WRITTEN: Final = "history.not_written"
NOT_KEPT: Final = "history.not_kept"
DAMAGED: Final = "history.damaged"


@final
class HistoryStore:
    """The file and its troubles.

    Args:
        path: The file; None for memory.

    Attributes:
        problem: The trouble of the file, as text; empty if there is none.
        failures: Times that it could not be written or read.
        is_unusable: Whether no history can be kept until the next start.
    """

    def __init__(self, node: Node, path: Path | None, settings: HistorySettings) -> None:
        self._node = node
        self._clock = node.graph.clock
        self._settings = settings
        self.file = HistoryFile(path, settings.keep)
        self._turn = anyio.Lock()
        self._limit = LogLimit(self._clock)
        self.problem = ""
        self.failures = 0
        self.is_unusable = False

    async def open(self) -> StoredSeries | None:
        """Return the series of the file; None if it cannot be used now."""
        async with self._turn:
            try:
                damaged = await to_thread.run_sync(self.file.open, self._clock.now())
                if damaged is not None:
                    self._log_damage(damaged)
                stored = await to_thread.run_sync(self.file.load)
            except UsageError as exc:
                self.problem, self.is_unusable = str(exc), True
                self._node.log.warning(NOT_KEPT, message=f"{exc}; until the next start no history is kept")
            except (LinkError, WireError) as exc:
                self._record_failure(exc)
            else:
                self.problem = ""
                return stored
        return None

    async def write(self, collector: Collector) -> None:
        """Write what *collector* has; what cannot be written now stays there."""
        async with self._turn:
            try:
                if await to_thread.run_sync(self.file.is_lost):
                    await self._begin_anew(collector)
                batch = collector.take()
                try:
                    await to_thread.run_sync(self.file.write, batch, round(self._clock.now() * 1000))
                except BaseException:
                    collector.put_back(batch)
                    raise
            except WireError as exc:
                self._record_failure(exc)
                self._log_damage(await to_thread.run_sync(self.file.set_aside, self._clock.now()))
                await self._begin_anew(collector)
            except LinkError as exc:
                self._record_failure(exc)
            else:
                collector.written(batch)
                self.problem = ""

    async def read(self, collector: Collector, work: Callable[[HistoryReader], T]) -> T:
        """Return the result of *work*, in a thread.

        Raises:
            LinkError: The file cannot be read now.
            WireError: The file is damaged.
        """
        async with self._turn:
            batch, now = collector.batch.copy(), round(self._clock.now() * 1000)
            counters = collector.counters

            def run() -> T:
                return work(HistoryReader(self.file.connection, batch, self._settings.keep, counters, now))

            return await to_thread.run_sync(run)

    async def close(self) -> None:
        """Close the file."""
        async with self._turn:
            await to_thread.run_sync(self.file.close)

    async def _begin_anew(self, collector: Collector) -> None:
        """Begin a new file in place of one that was removed or damaged."""
        await to_thread.run_sync(self.file.open, self._clock.now())
        await to_thread.run_sync(self.file.load)
        collector.renew()

    def _record_failure(self, exc: LinkError | WireError) -> None:
        self.problem = str(exc)
        self.failures += 1
        if self._limit.allows(NOT_WRITTEN) is not None:
            self._node.log.warning(NOT_WRITTEN, message=f"{exc}; trying again")

    def _log_damage(self, where: Path) -> None:
        text = f"the history was damaged; it was moved to {where}, and a new one is begun"
        self._node.log.warning(DAMAGED, message=text, file=str(where))
