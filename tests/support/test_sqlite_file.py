"""Upgrade of a file: a copy first, then one transaction a step; a file that cannot be upgraded stays as it was."""

import sqlite3
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from homebot.errors import LinkError, UsageError
from homebot.support.sqlite_file import SqliteFile, SqliteSchema

Migrations = Mapping[int, Sequence[str]]

GOOD = {1: ("ALTER TABLE words ADD COLUMN two",), 2: ("ALTER TABLE words ADD COLUMN three",)}


def schema(version: int, migrations: Migrations) -> SqliteSchema:
    return SqliteSchema("file of words", version, ("CREATE TABLE words (one)",), ("SELECT one FROM words",), migrations)


@pytest.fixture
def old(tmp_path: Path) -> Path:
    """A file of version 1, with a word."""
    path = tmp_path / "words.sqlite"
    file = SqliteFile(path, schema(1, {}))
    file.open(0.0)
    file.close()
    with sqlite3.connect(path) as connection:
        connection.execute("INSERT INTO words VALUES ('hello')")
    connection.close()
    return path


def content(path: Path) -> tuple[int, list[tuple[str | None, ...]]]:
    connection = sqlite3.connect(path)
    try:
        version = connection.execute("PRAGMA user_version").fetchone()[0]
        return version, connection.execute("SELECT * FROM words").fetchall()
    finally:
        connection.close()


def upgrade(path: Path, migrations: Migrations) -> None:
    file = SqliteFile(path, schema(3, migrations))
    try:
        file.open(0.0)
    finally:
        file.close()


def test_an_older_file_is_upgraded_and_a_copy_of_it_kept(old: Path) -> None:
    upgrade(old, GOOD)
    assert content(old) == (3, [("hello", None, None)])
    copy = old.with_name("words.sqlite.version-1")
    assert content(copy) == (1, [("hello",)])
    assert copy.stat().st_mode & 0o077 == 0
    upgrade(old, GOOD)
    assert sorted(one.name for one in old.parent.iterdir()) == ["words.sqlite", "words.sqlite.version-1"]


def test_a_step_that_fails_is_undone_and_goes_on_from_there(old: Path) -> None:
    """The step before stays done; the next try begins after it."""
    with pytest.raises(LinkError, match="cannot be opened"):
        upgrade(old, {**GOOD, 2: ("ALTER TABLE words ADD COLUMN three", "ALTER TABLE nothing ADD COLUMN four", "?")})
    assert content(old) == (2, [("hello", None)])
    upgrade(old, GOOD)
    assert content(old) == (3, [("hello", None, None)])
    assert content(old.with_name("words.sqlite.version-1")) == (1, [("hello",)])


def test_a_newer_file_is_refused_and_left_alone(old: Path) -> None:
    upgrade(old, GOOD)
    before = old.read_bytes()
    with pytest.raises(UsageError, match=r"was written by a newer homebot \(version 3, not 1\)"):
        SqliteFile(old, schema(1, {})).open(0.0)
    assert old.read_bytes() == before
