"""The stores of all apps, and their file, which is written behind them."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Final, final

import anyio
from anyio import to_thread

from homebot.apps.store import Store
from homebot.apps.store_file import StoreFile
from homebot.clock import Clock
from homebot.errors import LinkError, UsageError, WireError
from homebot.log import LogLimit
from homebot.support.logger import get_logger

__all__ = ["AppStores"]

NOT_WRITTEN = "app.store_not_written"
NOT_USED = "app.store_not_used"
DAMAGED = "app.store_damaged"
REMOVED = "app.store_removed"

WRITE_AFTER: Final = 5.0
"""Seconds in which changes are gathered, which a power cut loses."""

_LAST_CHANCE: Final = 5.0

_log = get_logger(node="/homebot")


@final
class AppStores:
    """The values of all apps: in memory, and in *path* if there is one.

    A file that turns out to be damaged, or was removed, is begun anew with all that is in memory. If another homebot
    uses it, or a newer one wrote it, values are in memory only.

    Args:
        path: The file; None for none.
    """

    def __init__(self, path: Path | None, clock: Clock) -> None:
        self._clock = clock
        self._file = None if path is None else StoreFile(path)
        if self._file is not None:
            self._file.write_rest = self.flush
        self._texts: dict[str, dict[str, str]] = {}
        self._stores: dict[str, Store] = {}
        self._written: set[tuple[str, str]] = set()
        self._changed: dict[tuple[str, str], None] = {}
        self._has_news = anyio.Event()
        self._turn = anyio.Lock()
        self._limit = LogLimit(clock)

    def of(self, app: str) -> Store:
        """Return the store of *app*, always the same one."""
        if app not in self._stores:
            texts = self._texts.setdefault(app, {})
            self._stores[app] = Store(app, texts, partial(self._record_change, app))
        return self._stores[app]

    async def read(self) -> None:
        """Read what is in the file; called before the first store is used."""
        async with self._turn:
            if (file := await self._opened(is_first=True)) is None:
                return
            try:
                self._texts = await to_thread.run_sync(file.read)
            except (LinkError, WireError) as exc:
                self._use_memory(str(exc))
        self._written = {(app, key) for app, texts in self._texts.items() for key in texts}

    async def run(self) -> None:
        """Write changes until cancelled."""
        while True:
            await self._has_news.wait()
            await anyio.sleep(WRITE_AFTER)
            self._has_news = anyio.Event()
            await self.flush()
            if self._changed:
                self._has_news.set()

    async def flush(self) -> None:
        """Write all changes now, within five seconds, cancelled or not; what cannot be written is tried again."""
        with anyio.move_on_after(_LAST_CHANCE, shield=True):
            async with self._turn:
                await self._write()

    async def close(self) -> None:
        """Write the rest and close the file."""
        await self.flush()
        with anyio.CancelScope(shield=True):
            async with self._turn:
                if self._file is not None:
                    await to_thread.run_sync(self._file.close)

    def _record_change(self, app: str, key: str) -> None:
        if self._file is None:
            return
        place = (app, key)
        if key in self._texts[app] or place in self._written:
            self._changed[place] = None
            self._has_news.set()
        else:  # it came and went before it was written
            self._changed.pop(place, None)

    async def _write(self) -> None:
        if not self._changed:
            return
        file = await self._opened()
        if file is None:
            return
        changes = {(app, key): self._texts[app].get(key) for app, key in self._changed}
        try:
            await to_thread.run_sync(file.write, changes)
        except WireError as exc:
            self._record_failure(exc)
            await self._set_aside(file)
        except LinkError as exc:
            self._record_failure(exc)
        else:
            for (app, key), text in changes.items():
                self._record_written(app, key, text)

    def _record_written(self, app: str, key: str, text: str | None) -> None:
        place = (app, key)
        if text is None:
            self._written.discard(place)
        else:
            self._written.add(place)
        if self._texts[app].get(key) == text:  # it may have changed meanwhile
            self._changed.pop(place, None)
        else:
            self._changed[place] = None

    async def _opened(self, *, is_first: bool = False) -> StoreFile | None:
        """Return the open file; None if it cannot be used now."""
        file = self._file
        if file is None:
            return None
        if file.is_open:
            if not await to_thread.run_sync(file.is_lost):
                return file
            await to_thread.run_sync(file.close)
            _log.warning(REMOVED, message=f"{file.path} was removed while homebot ran; a new one is begun")
            self._write_all_anew()
        try:
            damaged = await to_thread.run_sync(file.open, self._clock.now())
        except UsageError as exc:
            self._use_memory(str(exc))
            return None
        except LinkError as exc:
            if is_first:  # to write over what cannot be read would lose it
                self._use_memory(str(exc))
            else:
                self._record_failure(exc)
            return None
        if damaged is not None:
            self._report_damage(damaged)
        return file

    async def _set_aside(self, file: StoreFile) -> None:
        """Move a damaged file away; the next write begins a new one."""
        try:
            self._report_damage(await to_thread.run_sync(file.set_aside, self._clock.now()))
        except OSError as exc:
            self._use_memory(f"{file.path} cannot be set aside: {exc}")
        self._write_all_anew()

    def _write_all_anew(self) -> None:
        self._written.clear()
        self._changed = {(app, key): None for app, texts in self._texts.items() for key in texts}

    def _use_memory(self, why: str) -> None:
        if self._file is None:
            return
        message = f"{why}; until the next start, what apps keep is in memory alone"
        _log.warning(NOT_USED, message=message, file=str(self._file.path))
        self._file = None
        self._changed.clear()

    def _record_failure(self, exc: LinkError | WireError) -> None:
        held_back = self._limit.allows(NOT_WRITTEN)
        if held_back is not None:
            _log.warning(NOT_WRITTEN, message=f"{exc}; trying again", held_back=held_back)

    def _report_damage(self, where: Path) -> None:
        message = f"the file of the apps was damaged; it was moved to {where}, and a new one is used"
        _log.warning(DAMAGED, message=message, file=str(where))
