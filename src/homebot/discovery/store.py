"""The index file: an SQLite database with a row for each device. Blocking; called from a worker thread.

Source of the pragmas: SQLite 3 documentation, https://www.sqlite.org/pragma.html.
"""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import final

from homebot.discovery.record import Records
from homebot.errors import LinkError, UsageError, WireError
from homebot.file_access import why_not_trusted
from homebot.names import escape_token

__all__ = ["VERSION", "IndexFile", "index_path", "take_over"]

VERSION = 3
"""Of the schema, kept as SQLite's ``user_version``."""

_SCHEMA = (
    "CREATE TABLE devices (id TEXT PRIMARY KEY, record TEXT NOT NULL)",
    "CREATE TABLE tombstones (id TEXT PRIMARY KEY, record TEXT NOT NULL)",
    "CREATE TABLE owner (name TEXT PRIMARY KEY, record TEXT NOT NULL)",
)

_MIGRATIONS: dict[int, Sequence[str]] = {
    1: (_SCHEMA[1],),  # version 1 knew no tombstones
    2: (_SCHEMA[2],),  # version 2 knew nothing that the owner decides
}
"""What makes the next version out of each."""

_BUSY = 5.0
"""Seconds to wait for another homebot that holds the file."""

_FILES = ("", "-wal", "-shm", "-journal")


def index_path(home: str, network: str) -> Path:
    """Return where the index of a home is kept: below ``HOMEBOT_DATA``, or the user's directory for data.

    Args:
        home: What the home is called.
        network: Where its devices are, for example the broker's ``host:port``: another broker has other devices, and
            those of the first would be ghosts there.
    """
    return _data_directory() / escape_token(home) / escape_token(network) / "index.sqlite"


def take_over(path: Path) -> bool:
    """Move the index file of before there was one for each network to *path*, where nothing is yet; return whether.

    The first that starts takes it: it is most probably the network that the file was made in.
    """
    old = path.parent.parent / path.name
    if path.exists() or not old.exists():
        return False
    path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    for ending in _FILES:
        source = old.with_name(old.name + ending)
        with suppress(FileNotFoundError):
            source.rename(path.with_name(path.name + ending))
    return True


def _data_directory() -> Path:
    if given := os.environ.get("HOMEBOT_DATA"):
        return Path(given)
    from platformdirs import user_data_path  # noqa: PLC0415 - a start that keeps no index goes without

    return user_data_path("homebot", appauthor=False)


@final
class IndexFile:
    """Reads and writes the index file.

    Args:
        path: Where it is; directories are made.
        busy_timeout: Seconds to wait for another homebot that uses it and may be about to end.
    """

    def __init__(self, path: Path, busy_timeout: float = _BUSY) -> None:
        self.path = path
        self._busy_timeout = busy_timeout
        self._connection: sqlite3.Connection | None = None

    def open(self, now: float) -> Path | None:
        """Open the file, make it where there is none, and bring it to this version; a damaged one is set aside.

        Args:
            now: Seconds since the Unix epoch, for the name of a damaged file.

        Returns:
            Where a damaged file is now; None where it was whole.

        Raises:
            LinkError: It cannot be opened or written now, for example because the disk is full.
            UsageError: A newer homebot wrote it, or another one uses it now.
        """
        self.close()
        set_aside = None
        try:
            self._open()
        except sqlite3.DatabaseError as exc:
            if "locked" in str(exc):
                raise UsageError(
                    f"the index file {self.path} is in use by another homebot; give this one its own directory "
                    "(HOMEBOT_DATA), or run it with --ephemeral"
                ) from exc
            if not _is_damage(exc):
                raise LinkError(f"the index file {self.path} cannot be opened: {exc}") from exc
            set_aside = self._replace(now)
        except OSError as exc:
            raise LinkError(f"the index file {self.path} cannot be opened: {exc}") from exc
        return set_aside

    def read(self) -> Records:
        """Return all rows, devices in the order of their ids.

        Raises:
            LinkError: It cannot be read.
        """
        connection = self._opened()
        try:
            devices = connection.execute("SELECT id, record FROM devices ORDER BY id").fetchall()
            tombstones = connection.execute("SELECT id, record FROM tombstones ORDER BY id").fetchall()
            owner = connection.execute("SELECT name, record FROM owner ORDER BY name").fetchall()
        except sqlite3.Error as exc:
            raise LinkError(f"the index file {self.path} cannot be read: {exc}") from exc
        return Records(_texts(devices), _texts(tombstones), _texts(owner))

    def write(self, records: Records, gone: Sequence[str]) -> None:
        """Write the records in one transaction; *gone* are ids of which nothing is kept, or only what is written.

        Raises:
            LinkError: It cannot be written now; nothing of it was.
            WireError: The file is damaged; nothing was written.
        """
        connection = self._opened()
        try:
            with connection:
                rows = [(one,) for one in gone if _is_text(one)]
                stones = [(one, record) for one, record in records.tombstones if _is_text(one)]
                connection.executemany("DELETE FROM devices WHERE id = ?", rows)
                connection.executemany("DELETE FROM tombstones WHERE id = ?", rows)
                connection.executemany("INSERT OR REPLACE INTO devices VALUES (?, ?)", records.devices)
                connection.executemany("INSERT OR REPLACE INTO tombstones VALUES (?, ?)", stones)
                connection.executemany("INSERT OR REPLACE INTO owner VALUES (?, ?)", records.owner)
        except sqlite3.Error as exc:
            if _is_damage(exc):
                raise WireError(f"the index file {self.path} is damaged: {exc}", b"") from exc
            raise LinkError(f"the index file {self.path} cannot be written: {exc}") from exc

    def set_aside(self, now: float) -> Path:
        """Move the file away, so that the next one begins empty; return where it is now."""
        self.close()
        target = self.path.with_name(f"{self.path.name}.damaged-{now:.0f}")
        number = 1
        while target.exists():
            number += 1
            target = self.path.with_name(f"{self.path.name}.damaged-{now:.0f}-{number}")
        for ending in _FILES:
            source = self.path.with_name(self.path.name + ending)
            with suppress(FileNotFoundError):
                source.rename(target.with_name(target.name + ending))
        return target

    def close(self) -> None:
        """Close the file. Twice is fine."""
        if self._connection is not None:
            with suppress(sqlite3.Error):
                self._connection.close()
            self._connection = None

    def _replace(self, now: float) -> Path:
        """Set the damaged file aside and begin a new one; return where the damaged one is."""
        try:
            set_aside = self.set_aside(now)
            self._open()
        except (sqlite3.Error, OSError) as exc:
            raise LinkError(f"the index file {self.path} cannot be recreated: {exc}") from exc
        return set_aside

    def _open(self) -> None:
        self._make_private()
        connection = sqlite3.connect(
            self.path, timeout=self._busy_timeout, check_same_thread=False, isolation_level=None
        )
        try:
            # Two homebots of one file would overwrite each other's devices.
            connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            version = self._version(connection)
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = NORMAL")
            _check(connection)
            self._migrate(connection, version)
            connection.execute("SELECT id, record FROM devices LIMIT 1").fetchall()
            connection.execute("SELECT id, record FROM tombstones LIMIT 1").fetchall()
        except BaseException:
            connection.close()
            raise
        connection.isolation_level = "DEFERRED"
        self._connection = connection

    def _make_private(self) -> None:
        """Have a file that is the user's alone: what others could write there would be taken for what was heard.

        Raises:
            UsageError: Others may write it, or where it is.
        """
        self.path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if problem := why_not_trusted(self.path if self.path.exists() else self.path.parent):
            raise UsageError(f"the index file is not used: {problem}")
        self.path.touch(mode=0o600)
        found = self.path.stat()
        if os.name == "posix" and found.st_mode & 0o077 and found.st_uid == os.geteuid():
            self.path.chmod(0o600)

    def _version(self, connection: sqlite3.Connection) -> int:
        version = int(connection.execute("PRAGMA user_version").fetchone()[0])
        if version > VERSION:
            raise UsageError(
                f"the index file {self.path} was written by a newer homebot (version {version}, not {VERSION})"
            )
        return version

    def _migrate(self, connection: sqlite3.Connection, version: int) -> None:
        steps = _SCHEMA if version == 0 else [step for one in range(version, VERSION) for step in _MIGRATIONS[one]]
        connection.execute("BEGIN IMMEDIATE")
        try:
            for step in steps:
                connection.execute(step)
            connection.execute(f"PRAGMA user_version = {VERSION}")
        except BaseException:
            connection.execute("ROLLBACK")
            raise
        connection.execute("COMMIT")

    def _opened(self) -> sqlite3.Connection:
        if self._connection is None:
            raise LinkError(f"the index file {self.path} is not open")
        return self._connection


def _check(connection: sqlite3.Connection) -> None:
    (problem,) = connection.execute("PRAGMA quick_check(1)").fetchone()
    if problem != "ok":
        raise sqlite3.DatabaseError(problem)


def _is_damage(exc: sqlite3.Error) -> bool:
    """Return whether the file is at fault, rather than the disk or another program."""
    if not isinstance(exc, sqlite3.OperationalError):
        return isinstance(exc, sqlite3.DatabaseError)
    return "no such" in str(exc) or "already exists" in str(exc)


def _is_text(device_id: str) -> bool:
    """Return whether it is no half of a surrogate pair, of which no row can be."""
    return not any("\ud800" <= one <= "\udfff" for one in device_id)


def _texts(rows: Iterable[tuple[object, object]]) -> tuple[tuple[str, str], ...]:
    return tuple((one, record) for one, record in rows if isinstance(one, str) and isinstance(record, str))
