"""The index file: an SQLite database with a row per device. Blocking; called from a worker thread."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import final

from homebot.discovery.record import Records
from homebot.names import escape_token
from homebot.support.data_folder import data_directory
from homebot.support.sqlite_file import SqliteFile, SqliteSchema

INDEX_FILE = "index.sqlite"

VERSION = 3
"""Version of the schema, stored as SQLite's ``user_version``."""

_SCHEMA = (
    "CREATE TABLE devices (id TEXT PRIMARY KEY, record TEXT NOT NULL)",
    "CREATE TABLE tombstones (id TEXT PRIMARY KEY, record TEXT NOT NULL)",
    "CREATE TABLE owner (name TEXT PRIMARY KEY, record TEXT NOT NULL)",
)

_MIGRATIONS: dict[int, Sequence[str]] = {
    1: (_SCHEMA[1],),  # version 1 had no tombstones
    2: (_SCHEMA[2],),  # version 2 had no decisions of the owner
}
"""The migration from each version to the next."""


def index_path(home: str, network: str) -> Path:
    """Return the path of a home's index: below ``HOMEBOT_DATA``, or in the user's data directory.

    Args:
        network: The network of its devices, for example the broker's ``host:port``; another has other devices.
    """
    return data_directory() / escape_token(home) / escape_token(network) / INDEX_FILE


INDEX_SCHEMA = SqliteSchema(
    "index file",
    VERSION,
    _SCHEMA,
    ("SELECT id, record FROM devices LIMIT 1", "SELECT id, record FROM tombstones LIMIT 1"),
    _MIGRATIONS,
)


@final
class IndexFile(SqliteFile):
    """Reads and writes the index file.

    Args:
        path: The file; its directories are created.
        busy_timeout: Seconds to wait for another homebot that uses the file and may be about to exit.
    """

    def __init__(self, path: Path, busy_timeout: float = 5.0) -> None:
        super().__init__(path, INDEX_SCHEMA, busy_timeout)

    def read(self) -> Records:
        """Return all rows, devices ordered by id.

        Raises:
            LinkError: It cannot be read now.
            WireError: It is damaged.
        """
        with self._used("read") as connection:
            rows = [
                connection.execute(f"SELECT * FROM {table} ORDER BY 1").fetchall()  # noqa: S608 - of our own texts
                for table in Records._fields
            ]
        return Records(*map(_texts, rows))

    def write(self, records: Records, ids: Sequence[str]) -> None:
        """Write the records of *ids* in one transaction; the rows of ids without a record are deleted.

        When it returns, the owner's decisions are on the disk and survive a power failure.

        Raises:
            LinkError: It cannot be written now; nothing was written.
            WireError: The file is damaged; nothing was written.
        """
        with self._used("written") as connection:
            connection.execute(f"PRAGMA synchronous = {'FULL' if records.owner else 'NORMAL'}")
            with connection:
                stones = [(device_id, record) for device_id, record in records.tombstones if _is_text(device_id)]
                for table, rows in (("devices", records.devices), ("tombstones", stones)):
                    gone = set(ids).difference(device_id for device_id, _ in rows)
                    connection.executemany(
                        f"DELETE FROM {table} WHERE id = ?",  # noqa: S608 - of our own texts
                        [(device_id,) for device_id in gone if _is_text(device_id)],
                    )
                    # A replaced row would move, so that it and its index entry would be written too.
                    connection.executemany(
                        f"INSERT INTO {table} VALUES (?, ?) "  # noqa: S608 - of our own texts
                        "ON CONFLICT (id) DO UPDATE SET record = excluded.record",
                        rows,
                    )
                connection.executemany("INSERT OR REPLACE INTO owner VALUES (?, ?)", records.owner)


def _is_text(device_id: str) -> bool:
    """Return whether *device_id* can be stored: it has no lone surrogate."""
    return not any("\ud800" <= character <= "\udfff" for character in device_id)


def _texts(rows: Iterable[tuple[object, object]]) -> tuple[tuple[str, str], ...]:
    return tuple(
        (device_id, record) for device_id, record in rows if isinstance(device_id, str) and isinstance(record, str)
    )
