"""The file of what apps keep: an SQLite database with a row for each key. Blocking; called from a worker thread."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TypeAlias, final

from homebot.support.sqlite_file import SqliteFile, SqliteSchema

__all__ = ["STORE_SCHEMA", "Changes", "StoreFile"]

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
    page_size=512,  # a change writes whole pages, and most values are a few bytes
)


@final
class StoreFile(SqliteFile):
    """Reads and writes the file.

    Args:
        path: The file; directories are made.
    """

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
        found: dict[str, dict[str, str]] = {}
        for app, key, value in rows:
            if isinstance(app, str) and isinstance(key, str) and _is_json(value):
                found.setdefault(app, {})[key] = value
        return found

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
