"""The stores of all apps, and their file, which is written in the background."""

import json
from collections.abc import Mapping
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Final, TypeAlias, final

import anyio
from anyio import to_thread

from homebot.apps.store import Store
from homebot.clock import Clock
from homebot.errors import LinkError
from homebot.log import LogLimit
from homebot.support.logger import get_logger
from homebot.support.managed_file import ManagedFile
from homebot.support.sqlite_file import SqliteFile, SqliteSchema

WRITE_AFTER: Final = 5.0
"""Seconds for which changes are gathered, and which a power cut loses."""

_LAST_CHANCE: Final = 5.0
_log = get_logger(node="/homebot")

Changes: TypeAlias = "Mapping[tuple[str, str], str | None]"
"""The JSON text of each app and key; None for a removed one."""

STORE_SCHEMA = SqliteSchema(
    "file of the apps",
    1,
    (
        "CREATE TABLE store (app TEXT NOT NULL, key TEXT NOT NULL, value TEXT NOT NULL, PRIMARY KEY (app, key)) "
        "WITHOUT ROWID",
    ),
    ("SELECT app, key, value FROM store LIMIT 1",),
    page_size=512,  # each change writes whole pages, and most values have only a few bytes
)


@final
class AppStores:
    """The values of all apps: in memory, and in *path* if there is one.

    If the file is damaged or was deleted, a new one is written from memory. If another homebot uses it, or a newer one
    wrote it, values are in memory only.
    """

    def __init__(self, path: Path | None, clock: Clock) -> None:
        self._kept: ManagedFile[StoreFile] | None = None
        if path is not None:
            self._kept = ManagedFile(
                StoreFile(path),
                "the file of the apps",
                "the values of apps are in memory only",
                _log,
                clock.now,
                LogLimit(clock).allows,
                on_new=self._write_all_anew,
                on_end=self._use_memory,
            )
            self._kept.file.write_rest = self.flush
        self._texts: dict[str, dict[str, str]] = {}
        self._stores: dict[str, Store] = {}
        self._written: set[tuple[str, str]] = set()
        self._changed: dict[tuple[str, str], None] = {}
        self._has_news = anyio.Event()

    @property
    def trouble(self) -> str:
        """The problem with the file, as text; empty if there is none."""
        return "" if self._kept is None else self._kept.trouble

    def of(self, app: str) -> Store:
        """Return the store of *app*, always the same one."""
        if app not in self._stores:
            texts = self._texts.setdefault(app, {})
            self._stores[app] = Store(app, texts, partial(self._record_change, app))
        return self._stores[app]

    async def read(self) -> None:
        """Read the file; called before the first store is used."""
        if self._kept is not None:
            # Overwriting an unreadable file would lose its content, so there is no second attempt.
            with suppress(LinkError):
                async with self._kept.opened(retries=False) as file:
                    self._texts = await to_thread.run_sync(file.read)
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
        """Write all changes now, within five seconds, even when cancelled; failed ones are tried again."""
        with anyio.move_on_after(_LAST_CHANCE, shield=True), suppress(LinkError):
            await self._write()

    async def close(self) -> None:
        """Write the rest and close the file."""
        await self.flush()
        with anyio.CancelScope(shield=True):
            if self._kept is not None:
                await self._kept.close()

    def _record_change(self, app: str, key: str) -> None:
        if self._kept is None:
            return
        place = (app, key)
        if key in self._texts[app] or place in self._written:
            self._changed[place] = None
            self._has_news.set()
        else:  # added and removed before it was written
            self._changed.pop(place, None)

    async def _write(self) -> None:
        if self._kept is None or not self._changed:
            return
        async with self._kept.opened(writes=True) as file:
            changes = {(app, key): self._texts[app].get(key) for app, key in self._changed}
            await to_thread.run_sync(file.write, changes)
            for (app, key), text in changes.items():
                place = (app, key)
                if text is None:
                    self._written.discard(place)
                else:
                    self._written.add(place)
                if self._texts[app].get(key) == text:  # it may have changed meanwhile
                    self._changed.pop(place, None)
                else:
                    self._changed[place] = None

    def _write_all_anew(self) -> None:
        self._written.clear()
        self._changed = {(app, key): None for app, texts in self._texts.items() for key in texts}

    def _use_memory(self) -> None:
        self._kept = None
        self._changed.clear()


@final
class StoreFile(SqliteFile):
    """Reads and writes the file."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, STORE_SCHEMA)

    def read(self) -> dict[str, dict[str, str]]:
        """Return the JSON text of each key by app; rows with other values are left out.

        Raises:
            LinkError: It cannot be read now.
            WireError: It is damaged.
        """
        with self._used("read") as connection:
            rows = connection.execute("SELECT app, key, value FROM store").fetchall()
        by_app: dict[str, dict[str, str]] = {}
        for app, key, value in rows:
            if isinstance(app, str) and isinstance(key, str) and _is_json(value):
                by_app.setdefault(app, {})[key] = value
        return by_app

    def write(self, changes: Changes) -> None:
        """Write *changes* in one transaction.

        Raises:
            LinkError: It cannot be written now; nothing was written.
            WireError: It is damaged; nothing was written.
        """
        gone = [place for place, text in changes.items() if text is None]
        rows = [(*place, text) for place, text in changes.items() if text is not None]
        with self._used("written") as connection, connection:
            connection.executemany("DELETE FROM store WHERE app = ? AND key = ?", gone)
            connection.executemany("INSERT OR REPLACE INTO store VALUES (?, ?, ?)", rows)


def _is_json(value: object) -> bool:
    if not isinstance(value, str):
        return False
    try:
        json.loads(value)
    except (ValueError, RecursionError):
        return False
    return True
