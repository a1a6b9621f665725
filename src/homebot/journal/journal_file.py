"""The journal's file: an SQLite database with a row for each entry and each learnt record.

Blocking; called from a worker thread.
"""

import json
import sqlite3
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final, final

from homebot.devices.journal_messages import MAX_ENTRIES, JournalEntry, ReadJournalRequest, ReadJournalResponse
from homebot.journal.store import JournalNote, LearntRow
from homebot.messages import Time
from homebot.support.sqlite_file import SqliteFile, SqliteSchema

_LEARNT: Final = (
    "CREATE TABLE learnt (kind TEXT NOT NULL, name TEXT NOT NULL, record TEXT NOT NULL, at REAL NOT NULL, "
    "command TEXT NOT NULL, PRIMARY KEY (kind, name))"
)

JOURNAL_SCHEMA: Final = SqliteSchema(
    "journal",
    3,
    (
        "CREATE TABLE entries (number INTEGER PRIMARY KEY, at REAL NOT NULL, device TEXT NOT NULL, "
        "command TEXT NOT NULL, entry TEXT NOT NULL)",
        _LEARNT,
    ),
    (
        "SELECT number, at, device, command, entry FROM entries LIMIT 1",
        "SELECT kind, name, record, at, command FROM learnt LIMIT 1",
    ),
    {
        1: (_LEARNT,),  # version 1 had no learnt rows
        # Each index cost one page written per command; without them a query scans all 50 MB in a third of a second.
        2: tuple(f"DROP INDEX IF EXISTS entries_{column}" for column in ("at", "device", "command")),
    },
    page_size=512,
)

_SHARE: Final = 0.1
"""The share of the largest issuer's entries that is dropped when the file is full: a program that floods loses its own
entries, and dropping a few each time would cost more."""

_LARGEST_ISSUER: Final = (
    "SELECT CASE WHEN json_valid(entry) THEN json_extract(entry, '$.issuer') END AS issuer, count(*) FROM entries "
    "GROUP BY issuer ORDER BY sum(length(entry)) DESC LIMIT 1"
)
_DROP_OLDEST_OF_ISSUER: Final = (
    "DELETE FROM entries WHERE number IN (SELECT number FROM entries "
    "WHERE CASE WHEN json_valid(entry) THEN json_extract(entry, '$.issuer') END IS ? ORDER BY number LIMIT ?)"
)
_DROP_OLDER: Final = (
    "DELETE FROM entries WHERE number < "
    "coalesce((SELECT number FROM entries WHERE at >= ? ORDER BY number LIMIT 1), 9e18)"
)
"""Reads only the entries that it drops, because entries are roughly in order of time."""

_ROUNDS: Final = 20
_MAX_LEARNT: Final = 20_000


@final
class JournalFile(SqliteFile):
    """Reads and writes the journal's file.

    Args:
        path: The file; its directories are created.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(path, JOURNAL_SCHEMA)

    def write(self, notes: Sequence[JournalNote], learnt: Sequence[LearntRow], oldest: float, most_bytes: float) -> int:
        """Write *notes* as entries in one transaction, and drop the oldest; return how many entries were dropped.

        Args:
            notes: The entries, oldest first.
            learnt: Rows that replace earlier ones; a row without a record is removed.
            oldest: In seconds since the Unix epoch; older entries and rows are dropped.
            most_bytes: The largest size of all entries; beyond it the largest issuer's oldest tenth is dropped.

        Raises:
            LinkError: It cannot be written now; nothing was written.
            WireError: The file is damaged; nothing was written.
        """
        rows = [
            (entry.at.to_seconds(), entry.device, entry.command, _to_json(entry))
            for entry in map(JournalNote.entry, notes)
        ]
        with self._used("written") as connection, connection:
            connection.executemany("INSERT INTO entries (at, device, command, entry) VALUES (?, ?, ?, ?)", rows)
            _write_learnt(connection, learnt)
            connection.execute("DELETE FROM learnt WHERE at < ?", (oldest,))
            dropped = connection.execute(_DROP_OLDER, (oldest,)).rowcount
            for _ in range(_ROUNDS):
                if _size(connection) <= most_bytes:
                    break
                dropped += _drop_oldest(connection)
        return dropped

    def read_learnt(self) -> tuple[LearntRow, ...]:
        """Return the newest 20,000 learnt rows, oldest first; a row with values of wrong types has an empty record.

        Raises:
            LinkError: It cannot be read now.
            WireError: The file is damaged.
        """
        query = "SELECT kind, name, record, at FROM learnt ORDER BY at DESC LIMIT ?"
        with self._used("read") as connection:
            rows = connection.execute(query, (_MAX_LEARNT,)).fetchall()
        return tuple([_learnt_row(*row) for row in reversed(rows)])

    def read_entries(self, request: ReadJournalRequest) -> ReadJournalResponse:
        """Return the newest entries that fit; a row that cannot be read is left out.

        Raises:
            LinkError: It cannot be read now.
            WireError: The file is damaged.
        """
        limit = min(request.limit or MAX_ENTRIES, MAX_ENTRIES)
        conditions, values = _conditions(request)
        query = f"SELECT at, device, command, entry FROM entries{conditions} ORDER BY number DESC LIMIT ?"  # noqa: S608 - of our own texts
        with self._used("read") as connection:
            rows = connection.execute(query, (*values, limit + 1)).fetchall()
            first = connection.execute("SELECT at FROM entries ORDER BY number LIMIT 1").fetchone()
        entries = [entry for row in reversed(rows[:limit]) if (entry := _entry(*row)) is not None]
        begins = Time.from_seconds(first[0]) if first else Time(sec=0, nanosec=0)
        return ReadJournalResponse(entries=tuple(entries), complete=len(rows) <= limit, begins=begins)


def _conditions(request: ReadJournalRequest) -> tuple[str, tuple[object, ...]]:
    conditions: list[str] = []
    values: list[object] = []
    for condition, value in (
        ("device = ?", request.device),
        ("command = ?", request.command),
        ("at >= ?", request.since.to_seconds()),
        ("at <= ?", request.until.to_seconds()),
    ):
        if value:
            conditions.append(condition)
            values.append(value)
    if request.devices:
        conditions.append(f"device IN ({', '.join('?' * len(request.devices))})")
        values += request.devices
    return (f" WHERE {' AND '.join(conditions)}" if conditions else ""), tuple(values)


def _write_learnt(connection: sqlite3.Connection, learnt: Sequence[LearntRow]) -> None:
    gone = [(row.kind, row.name) for row in learnt if not row.record]
    connection.executemany("DELETE FROM learnt WHERE kind = ? AND name = ?", gone)
    rows = [row for row in learnt if row.record]
    connection.executemany("INSERT OR REPLACE INTO learnt VALUES (?, ?, ?, ?, '')", rows)  # formerly a command's id


def _learnt_row(kind: object, name: object, record: object, at: object) -> LearntRow:
    return LearntRow(
        str(kind),
        str(name),
        record if isinstance(record, str) else "",
        at if isinstance(at, float) else 0.0,
    )


def _size(connection: sqlite3.Connection) -> float:
    """Return the bytes of the used pages, without the learnt rows, which have their own limit."""
    pages, free, size = (
        int(connection.execute(f"PRAGMA {name}").fetchone()[0])
        for name in ("page_count", "freelist_count", "page_size")
    )
    (learnt,) = connection.execute("SELECT total(length(record) + length(name)) FROM learnt").fetchone()
    return (pages - free) * size - float(learnt)


def _drop_oldest(connection: sqlite3.Connection) -> int:
    """Drop the oldest entries of the issuer with the most bytes; return how many."""
    largest = connection.execute(_LARGEST_ISSUER).fetchone()
    if largest is None:
        return 0
    issuer, count = largest
    return connection.execute(_DROP_OLDEST_OF_ISSUER, (issuer, max(1, round(_SHARE * count)))).rowcount


def _to_json(entry: JournalEntry) -> str:
    """Return the fields of *entry* that have no column."""
    text = entry.model_dump_json(exclude_defaults=True, exclude={"at", "device", "command"})
    return text.encode(errors="replace").decode()


def _entry(at: Any, device: object, command: object, text: Any) -> JournalEntry | None:
    """Return the entry of a row; None if it cannot be read."""
    try:
        stamp = Time.from_seconds(at).model_dump()
        fields = {**json.loads(text), "at": stamp, "device": device, "command": command}
        return JournalEntry.model_validate_json(json.dumps(fields))
    except (TypeError, ValueError, RecursionError):
        return None
