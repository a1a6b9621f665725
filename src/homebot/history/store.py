"""The history's file, written and read by worker threads, one at a time."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import TypeVar, final

from anyio import to_thread

from homebot.errors import LinkError
from homebot.graph import Node
from homebot.history.collector import Collector
from homebot.history.history_file import HistoryFile, StoredSeries
from homebot.history.reading import HistoryReader
from homebot.history.settings import HistorySettings
from homebot.log import LogLimit
from homebot.support.kept_file import KeptFile

__all__ = ["HistoryStore"]

T = TypeVar("T")


@final
class HistoryStore:
    """The file and its use.

    Args:
        path: The file; None for memory.

    Attributes:
        kept: The use of the file, with its troubles.
    """

    def __init__(self, node: Node, path: Path | None, settings: HistorySettings) -> None:
        self._clock = clock = node.graph.clock
        self._settings = settings
        self.file = HistoryFile(path, settings.keep)
        self.kept = KeptFile(
            self.file, "the history", "no history is kept", node.log, clock.now, LogLimit(clock).allows, self._renew
        )
        self._is_new = False

    async def open(self) -> StoredSeries | None:
        """Return the series of the file; None if it cannot be used now."""
        with suppress(LinkError):
            async with self.kept.opened(writes=True) as file:
                return await to_thread.run_sync(file.load)
        return None

    async def write(self, collector: Collector) -> None:
        """Write what *collector* has; what cannot be written now stays there."""
        with suppress(LinkError):
            async with self.kept.opened(writes=True) as file:
                if self._is_new:
                    collector.renew()
                    self._is_new = False
                batch = collector.take()
                try:
                    await to_thread.run_sync(file.write, batch, round(self._clock.now() * 1000))
                except BaseException:
                    collector.put_back(batch)
                    raise
                collector.written(batch)

    async def read(self, collector: Collector, work: Callable[[HistoryReader], T]) -> T:
        """Return the result of *work*, in a thread.

        Raises:
            LinkError: The file cannot be read now.
        """
        async with self.kept.opened() as file:
            batch, now = collector.batch.copy(), round(self._clock.now() * 1000)
            counters = collector.counters

            def run() -> T:
                return work(HistoryReader(file.connection, batch, self._settings.keep, counters, now))

            return await to_thread.run_sync(run)

    def _renew(self) -> None:
        """Have all series written again: the file is a new one."""
        self._is_new = True
