"""The use of an SQLite file from the event loop: its work is done in threads, its troubles are logged and mended."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Final, Generic, TypeVar, final

import anyio
from anyio import to_thread

from homebot.errors import LinkError, UsageError, WireError

if TYPE_CHECKING:
    from structlog.typing import FilteringBoundLogger

    from homebot.support.sqlite_file import SqliteFile

DAMAGED: Final = "file.damaged"
REMOVED: Final = "file.removed"
NOT_WRITTEN: Final = "file.not_written"
WRITTEN_AGAIN: Final = "file.written_again"
NOT_USED: Final = "file.not_used"

F = TypeVar("F", bound="SqliteFile")


def _do_nothing() -> None:
    pass


@final
class ManagedFile(Generic[F]):
    """A file, used by one task at a time.

    In place of a damaged one, which is moved aside, and of one that was removed, the next use begins a new one. One
    that another homebot uses, or that a newer one wrote, is not used until the next start.

    Args:
        title: Its name in the log, such as ``the journal``.
        without: What is so without it, in the log, such as ``the journal is in memory only``.
        now: Returns seconds since the Unix epoch.
        allows: The limit of lines in the log, :meth:`homebot.log.LogLimit.allows`.
        on_new: Called when it has lost all that was written.
        on_end: Called when it is used no longer.

    Attributes:
        problem: Its trouble, as text; empty if there is none.
        loss: What was lost by its removal or damage, as text; stays to the next start.
        failures: Times that it could not be written or read.
        is_unusable: Whether it is not used until the next start.
    """

    def __init__(
        self,
        file: F,
        title: str,
        without: str,
        log: FilteringBoundLogger,
        now: Callable[[], float],
        allows: Callable[[str], int | None],
        on_new: Callable[[], None] = _do_nothing,
        on_end: Callable[[], None] = _do_nothing,
    ) -> None:
        self.file = file
        self.problem = self.loss = ""
        self.failures = 0
        self.is_unusable = False
        self._title, self._without = title, without
        self._log, self._now, self._allows = log, now, allows
        self._on_new, self._on_end = on_new, on_end
        self._turn = anyio.Lock()

    @asynccontextmanager
    async def opened(self, *, writes: bool = False, retries: bool = True) -> AsyncIterator[F]:
        """Yield the open file; errors of its work in the block are logged.

        Args:
            writes: Whether the block writes, so that its end shows that the file can be written.
            retries: Whether it is used again after an error.

        Raises:
            LinkError: It cannot be used now.
        """
        async with self._turn:
            try:
                await self._open()
                yield self.file
            except WireError as exc:
                self._record_failure(exc)
                try:
                    self._report_damage(await to_thread.run_sync(self.file.set_aside, self._now()))
                except OSError as error:
                    self._record_failure(LinkError(f"{self.file.path} cannot be moved aside: {error}"))
                raise LinkError(str(exc)) from exc
            except LinkError as exc:
                self._record_failure(exc) if retries else self._disable(str(exc))
                raise
            if writes and self.problem:
                self.problem = ""
                self._log.info(
                    WRITTEN_AGAIN, message=f"{self.file.path} can be written again", file=str(self.file.path)
                )

    @property
    def trouble(self) -> str:
        """The trouble for health reports, as text: also a loss."""
        return self.problem or self.loss

    async def close(self) -> None:
        """Close the file."""
        async with self._turn:
            await to_thread.run_sync(self.file.close)

    async def _open(self) -> None:
        if self.is_unusable:
            raise LinkError(self.problem)
        if self.file.is_open:
            if not await to_thread.run_sync(self.file.is_lost):
                return
            await to_thread.run_sync(self.file.close)
            self.loss = f"{self._title} {self.file.path} was removed or replaced while homebot ran"
            message = f"{self.loss}; a new one is begun; stop homebot before you move it"
            self._log.warning(REMOVED, message=message, file=str(self.file.path))
            self._on_new()
        try:
            damaged = await to_thread.run_sync(self.file.open, self._now())
        except UsageError as exc:
            self._disable(str(exc))
            raise LinkError(str(exc)) from exc
        if damaged is not None:
            self._report_damage(damaged)

    def _disable(self, why: str) -> None:
        if not self.is_unusable:
            self.is_unusable, self.problem = True, why
            message = f"{why}; until the next start {self._without}"
            self._log.warning(NOT_USED, message=message, file=str(self.file.path))
            self._on_end()

    def _record_failure(self, exc: LinkError | WireError) -> None:
        if self.is_unusable:
            return
        self.problem = str(exc)
        self.failures += 1
        if (held_back := self._allows(NOT_WRITTEN)) is not None:
            message = f"{exc}; trying again"
            self._log.warning(NOT_WRITTEN, message=message, file=str(self.file.path), held_back=held_back)

    def _report_damage(self, where: Path) -> None:
        self.loss = f"{self._title} {self.file.path} was damaged; it was moved to {where}, and a new one is used"
        self._log.warning(DAMAGED, message=self.loss, file=str(where))
        self._on_new()
