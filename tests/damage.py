"""Damage of an SQLite file while it is open, as SQLite finds it on a worn card."""

from homebot.support.sqlite_file import SqliteFile


def damage(file: SqliteFile) -> None:
    """Let the tables of *file* begin on pages that it does not have; its next use fails with SQLITE_CORRUPT."""
    connection = file._opened()
    connection.execute("PRAGMA writable_schema = ON")
    connection.execute("UPDATE sqlite_master SET rootpage = 999999 WHERE type = 'table'")
    connection.commit()
    connection.execute("PRAGMA writable_schema = RESET")
