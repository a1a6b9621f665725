"""An SQLite file of homebot's: private, owned by one process, migrated, and set aside if damaged.

Blocking; called from a worker thread. Source of the pragmas: SQLite 3 documentation, https://www.sqlite.org/pragma.html.
"""

from __future__ import annotations

import os
import sqlite3
import time
from collections.abc import Awaitable, Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar
from weakref import WeakSet

from homebot.errors import LinkError, UsageError, WireError
from homebot.support.file_access import why_not_trusted

_FILES = ("", "-wal", "-shm", "-journal")
"""The suffixes of the files of one database."""

_BUSY = 5.0
"""Seconds to wait for another homebot that uses the file."""


@dataclass(frozen=True, slots=True)
class SqliteSchema:
    """The tables of a file.

    Attributes:
        title: Name of the file in errors, for example ``index file``.
        version: Version of the schema, stored as SQLite's ``user_version``.
        page_size: Bytes of a page of a new file; every change writes a whole page.
        shrinks: Whether a new file can release unused pages, by ``incremental_vacuum``.
    """

    title: str
    version: int
    statements: Sequence[str]
    checks: Sequence[str]
    migrations: Mapping[int, Sequence[str]] = field(default_factory=dict)
    page_size: int = 4096
    shrinks: bool = False


IN_MEMORY = Path(":memory:")
"""The path of a database without a file."""

_COPY_WITHIN = 10.0
"""Seconds to wait for the end of a transaction, which takes milliseconds, or longer on a slow disk."""

_MAGIC = b"SQLite format 3\0"
_VERSION_AT = 60


def why_not_readable(path: Path, schema: SqliteSchema) -> str:
    """Return why a file that is not open anywhere cannot be used by this homebot; empty if it can.

    Raises:
        OSError: It cannot be read.
    """
    with path.open("rb") as file:
        head = file.read(100)
    if head and not head.startswith(_MAGIC):
        return "it is no file of SQLite"
    return _why_not_ours(int.from_bytes(head[_VERSION_AT : _VERSION_AT + 4]), schema)


def copy_database(path: Path, target: Path) -> None:
    """Copy a file that is not open anywhere to the new file *target*.

    Raises:
        LinkError: A homebot has it open, it is damaged, or the copy cannot be written.
    """
    try:
        connection = sqlite3.connect(path, timeout=0.1, isolation_level=None)
        try:
            _vacuum_into(connection, target)
        finally:
            connection.close()
    except sqlite3.Error as exc:
        problem = "is in use by a running homebot" if is_in_use(exc) else f"cannot be copied: {exc}"
        raise LinkError(f"{path} {problem}") from exc


def _vacuum_into(connection: sqlite3.Connection, target: Path) -> None:
    target.touch(mode=0o600)
    ends = time.monotonic() + _COPY_WITHIN
    while True:
        try:
            connection.execute("VACUUM INTO ?", (str(target),))
        except sqlite3.OperationalError as exc:
            if "VACUUM" not in str(exc) or time.monotonic() > ends:  # during another thread's transaction
                raise
            time.sleep(0.01)
        else:
            return


def is_in_use(exc: sqlite3.Error) -> bool:
    """Return whether another process has the file open."""
    return _code(exc) == sqlite3.SQLITE_BUSY


def _is_damage(exc: sqlite3.Error) -> bool:
    """Return whether the file is at fault, rather than the disk, another program or a mistake of homebot's own."""
    return _code(exc) in (sqlite3.SQLITE_CORRUPT, sqlite3.SQLITE_NOTADB)


def _code(exc: sqlite3.Error) -> int:
    """Return SQLite's primary result code; SQLITE_OK if *exc* is of Python's module alone."""
    return int(getattr(exc, "sqlite_errorcode", sqlite3.SQLITE_OK)) & 0xFF


def _why_not_ours(version: int, schema: SqliteSchema) -> str:
    is_newer = version > schema.version
    return f"was written by a newer homebot (version {version}, not {schema.version})" if is_newer else ""


class SqliteFile:
    """Opens and replaces the file; derived classes define its content.

    Args:
        path: The file, whose directories are created; :data:`IN_MEMORY` for none.
        busy_timeout: Seconds to wait for another homebot that uses the file and may be about to exit.

    Attributes:
        write_rest: Writes pending data of its user, in the event loop; None if there is never much.
    """

    _all: ClassVar[WeakSet[SqliteFile]] = WeakSet()

    def __init__(self, path: Path, schema: SqliteSchema, busy_timeout: float = _BUSY) -> None:
        self._all.add(self)
        self.path = path
        self.write_rest: Callable[[], Awaitable[object]] | None = None
        self._schema = schema
        self._busy_timeout = busy_timeout
        self._connection: sqlite3.Connection | None = None
        self._identity = (0, 0)

    def open(self, now: float) -> Path | None:
        """Open, create or migrate the file; a damaged one is set aside. It is checked only if it was not closed.

        Args:
            now: Seconds since the Unix epoch, for the name of a damaged file.

        Returns:
            The new path of a damaged file; None if it was intact.

        Raises:
            LinkError: It cannot be opened or written now, for example because the disk is full.
            UsageError: A newer homebot wrote it, or another one uses it now.
        """
        self.close()
        set_aside = None
        try:
            self._open()
        except WireError:
            set_aside = self._replace(now)
        except sqlite3.Error as exc:
            if is_in_use(exc):
                raise UsageError(
                    f"{self._title} is in use by another homebot; give this one its own directory "
                    "(HOMEBOT_DATA), or run it with --ephemeral"
                ) from exc
            if not _is_damage(exc):
                raise LinkError(f"{self._title} cannot be opened: {exc}") from exc
            set_aside = self._replace(now)
        except PermissionError as exc:
            advice = "give homebot a directory that it may write (HOMEBOT_DATA), or run it with --ephemeral"
            raise LinkError(f"{self._title} cannot be opened: {exc.strerror}; {advice}") from exc
        except OSError as exc:
            raise LinkError(f"{self._title} cannot be opened: {exc.strerror or exc}") from exc
        return set_aside

    @property
    def is_open(self) -> bool:
        """True while it is open."""
        return self._connection is not None

    @classmethod
    def opened_in(cls, folder: Path) -> dict[str, SqliteFile]:
        """Return the files in *folder* that this process has open, by name."""
        return {file.path.name: file for file in cls.used_in(folder) if file.is_open}

    @classmethod
    def used_in(cls, folder: Path) -> list[SqliteFile]:
        """Return the files in *folder* that this process uses, including those not opened yet."""
        return [file for file in list(cls._all) if file.path.parent == folder]

    def copy_into(self, target: Path) -> None:
        """Copy everything written so far to the new file *target*. From any thread.

        Raises:
            LinkError: It cannot be written, or the file is not open.
        """
        try:
            _vacuum_into(self._opened(), target)
        except sqlite3.Error as exc:
            raise LinkError(f"{self._title} cannot be copied: {exc}") from exc

    def is_lost(self) -> bool:
        """Return whether the open file was removed or replaced, so that writes are lost."""
        try:
            return self._find_identity() != self._identity
        except OSError:
            return True

    def set_aside(self, now: float) -> Path:
        """Move the file away, so that the next one is empty; return its new path."""
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
        """Close the file. Idempotent."""
        if self._connection is not None:
            with suppress(sqlite3.Error):
                self._connection.close()
            self._connection = None

    def _find_identity(self) -> tuple[int, int]:
        if self.path == IN_MEMORY:
            return 0, 0
        status = self.path.stat()
        return status.st_dev, status.st_ino

    def _replace(self, now: float) -> Path:
        """Set the damaged file aside and create a new one; return the new path of the damaged one."""
        try:
            set_aside = self.set_aside(now)
            self._open()
        except (sqlite3.Error, OSError, WireError) as exc:
            raise LinkError(f"{self._title} cannot be recreated: {exc}") from exc
        return set_aside

    def _open(self) -> None:
        self._make_private()
        was_closed = not any(self.path.with_name(self.path.name + ending).exists() for ending in _FILES[1:])
        connection = sqlite3.connect(
            self.path, timeout=self._busy_timeout, check_same_thread=False, isolation_level=None
        )
        try:
            # Two homebots with one file would overwrite each other's devices.
            connection.execute("PRAGMA locking_mode = EXCLUSIVE")
            version = self._version(connection)
            connection.execute(f"PRAGMA page_size = {self._schema.page_size}")
            if self._schema.shrinks:
                connection.execute("PRAGMA auto_vacuum = INCREMENTAL")
            connection.execute("PRAGMA journal_mode = WAL")
            connection.execute("PRAGMA synchronous = NORMAL")
            if not was_closed:  # SQLite itself finds other damage where it reads
                (problem,) = connection.execute("PRAGMA quick_check(1)").fetchone()
                if problem != "ok":
                    raise WireError(f"{self._title} is damaged: {problem}")
            schema = self._schema  # migrated step by step, each in a transaction, after making a copy
            if 0 < version < schema.version:
                copy = self.path.with_name(f"{self.path.name}.version-{version}")
                copy.unlink(missing_ok=True)  # an earlier step failed
                _vacuum_into(connection, copy)
                for number in range(version, schema.version):
                    _apply(connection, schema.migrations[number], number + 1)
            else:
                _apply(connection, schema.statements if version == 0 else (), schema.version)
            for check in self._schema.checks:
                connection.execute(check).fetchall()
        except BaseException:
            connection.close()
            raise
        connection.isolation_level = "DEFERRED"
        self._connection, self._identity = connection, self._find_identity()

    def _make_private(self) -> None:
        """Require that only the user can write the file, as others could forge entries.

        Raises:
            UsageError: Others may write it, or its folder.
        """
        if self.path == IN_MEMORY:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        if problem := why_not_trusted(self.path if self.path.exists() else self.path.parent):
            raise UsageError(f"the {self._schema.title} is not used: {problem}")
        self.path.touch(mode=0o600)
        status = self.path.stat()
        if os.name == "posix" and status.st_mode & 0o077 and status.st_uid == os.geteuid():
            self.path.chmod(0o600)

    def _version(self, connection: sqlite3.Connection) -> int:
        version = int(connection.execute("PRAGMA user_version").fetchone()[0])
        if problem := _why_not_ours(version, self._schema):
            raise UsageError(f"{self._title} {problem}")
        return version

    @contextmanager
    def _used(self, what: str) -> Iterator[sqlite3.Connection]:
        """Yield the connection for an operation, for example ``written``.

        Raises:
            LinkError: The disk or another program is at fault, or the file is not open.
            WireError: The file is damaged.
        """
        try:
            yield self._opened()
        except sqlite3.Error as exc:
            if _is_damage(exc):
                raise WireError(f"{self._title} is damaged: {exc}") from exc
            raise LinkError(f"{self._title} cannot be {what}: {exc}") from exc

    @property
    def _title(self) -> str:
        return f"the {self._schema.title} {self.path}"

    def _opened(self) -> sqlite3.Connection:
        if self._connection is None:
            raise LinkError(f"{self._title} is not open")
        return self._connection


def _apply(connection: sqlite3.Connection, steps: Sequence[str], version: int) -> None:
    """Carry out *steps* to *version* in a transaction; even without steps it makes the file this process's own."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        for step in steps:
            connection.execute(step)
        connection.execute(f"PRAGMA user_version = {version}")
    except BaseException:
        if connection.in_transaction:  # some errors end it
            connection.execute("ROLLBACK")
        raise
    connection.execute("COMMIT")
