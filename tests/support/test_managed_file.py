"""A kept file goes on after each trouble, and tells of it."""

import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest
from structlog.testing import capture_logs
from structlog.typing import EventDict
from tests.damage import damage

from homebot.errors import LinkError
from homebot.support.logger import get_logger
from homebot.support.managed_file import ManagedFile
from homebot.support.sqlite_file import SqliteFile, SqliteSchema

WORDS = SqliteSchema("file of words", 1, ("CREATE TABLE words (one)",), ("SELECT one FROM words",))


class WordFile(SqliteFile):
    """Words, written and read."""

    def __init__(self, path: Path) -> None:
        super().__init__(path, WORDS, busy_timeout=0.1)

    def write(self, word: str) -> None:
        with self._used("written") as connection, connection:
            connection.execute("INSERT INTO words VALUES (?)", (word,))

    def read(self) -> list[str]:
        with self._used("read") as connection:
            return [one for (one,) in connection.execute("SELECT one FROM words")]


class Kept:
    """A kept file that counts what it tells of itself."""

    def __init__(self, path: Path) -> None:
        self.renewals = self.ends = 0
        self.file = ManagedFile(
            WordFile(path),
            "the words",
            "words are lost",
            get_logger(),
            lambda: 7.0,
            lambda _: 0,
            self._renew,
            self._end,
        )

    async def write(self, word: str) -> None:
        async with self.file.opened(writes=True) as file:
            file.write(word)

    async def execute(self, statement: str, values: tuple[str, ...]) -> None:
        async with self.file.opened(writes=True) as file:
            with file._used("written") as connection:
                connection.execute(statement, values)

    async def read(self) -> list[str]:
        async with self.file.opened() as file:
            return file.read()

    def _renew(self) -> None:
        self.renewals += 1

    def _end(self) -> None:
        self.ends += 1


@pytest.fixture
def lines() -> Iterator[list[EventDict]]:
    with capture_logs() as lines:
        yield lines


def events(lines: list[EventDict]) -> list[str]:
    return [line["event"] for line in lines]


async def test_in_place_of_a_removed_file_a_new_one_is_begun(tmp_path: Path, lines: list[EventDict]) -> None:
    kept = Kept(tmp_path / "words.sqlite")
    await kept.write("one")
    for file in tmp_path.iterdir():
        file.unlink()
    await kept.write("two")
    assert await kept.read() == ["two"]
    assert (events(lines), kept.renewals) == (["file.removed"], 1)
    assert kept.file.loss.endswith("was removed or replaced while homebot ran")
    await kept.file.close()


async def test_a_file_that_breaks_at_work_is_moved_aside(tmp_path: Path, lines: list[EventDict]) -> None:
    kept = Kept(tmp_path / "words.sqlite")
    await kept.write("one")
    async with kept.file.opened() as file:
        damage(file)
    with pytest.raises(LinkError, match="is damaged: malformed database schema"):
        await kept.read()
    await kept.write("two")
    assert await kept.read() == ["two"]
    assert events(lines) == ["file.not_written", "file.damaged", "file.written_again"]
    assert (kept.renewals, kept.file.problem) == (1, "")
    assert kept.file.trouble.endswith("words.sqlite.damaged-7, and a new one is used")
    assert (tmp_path / "words.sqlite.damaged-7").exists()
    await kept.file.close()


async def test_a_mistake_of_our_own_leaves_the_file_and_its_rows(tmp_path: Path) -> None:
    kept = Kept(tmp_path / "words.sqlite")
    await kept.write("one")
    for statement, values in (("INSERT INTO words VALUES (?)", ()), ("SELECT * FROM wrods", ())):
        with pytest.raises(LinkError, match="cannot be written"):
            await kept.execute(statement, values)
    assert await kept.read() == ["one"]
    assert (kept.renewals, kept.file.failures, kept.file.loss) == (0, 2, "")
    assert not list(tmp_path.glob("*damaged*"))
    await kept.file.close()


async def test_what_cannot_be_written_now_is_a_problem_until_it_can_be(tmp_path: Path, lines: list[EventDict]) -> None:
    """That it can be read says nothing of writing."""
    kept = Kept(tmp_path / "words.sqlite")
    async with kept.file.opened() as file:
        fails = "SELECT abs(-9223372036854775808)"  # an error of the statement, as a full disk is one
        file._opened().execute(f"CREATE TRIGGER full BEFORE INSERT ON words BEGIN {fails}; END")
    with pytest.raises(LinkError, match="cannot be written"):
        await kept.write("one")
    assert await kept.read() == []
    assert "cannot be written" in kept.file.problem
    async with kept.file.opened() as file:
        file._opened().execute("DROP TRIGGER full")
    await kept.write("one")
    assert (kept.file.problem, kept.file.failures, kept.renewals) == ("", 1, 0)
    assert events(lines) == ["file.not_written", "file.written_again"]
    await kept.file.close()


async def test_a_file_that_another_homebot_uses_is_not_used(tmp_path: Path, lines: list[EventDict]) -> None:
    other, kept = Kept(tmp_path / "words.sqlite"), Kept(tmp_path / "words.sqlite")
    await other.write("one")
    for _ in range(2):
        with pytest.raises(LinkError, match="in use by another homebot"):
            await kept.write("two")
    assert (kept.file.is_unusable, kept.ends, kept.file.failures) == (True, 1, 0)
    assert events(lines) == ["file.not_used"]
    assert lines[0]["message"].endswith("until the next start words are lost")
    await other.file.close()


async def test_a_file_that_must_be_read_at_once_is_not_tried_again(tmp_path: Path, lines: list[EventDict]) -> None:
    (tmp_path / "folder").write_text("in the way")
    kept = Kept(tmp_path / "folder" / "words.sqlite")
    with pytest.raises(LinkError, match="cannot be opened"):
        async with kept.file.opened(retries=False):
            pass
    assert (kept.file.is_unusable, events(lines)) == (True, ["file.not_used"])


async def test_a_newer_file_stays_as_it_is(tmp_path: Path) -> None:
    path = tmp_path / "words.sqlite"
    kept = Kept(path)
    await kept.write("one")
    await kept.file.close()
    with closing(sqlite3.connect(path)) as connection:
        connection.execute("PRAGMA user_version = 99")
    before = path.read_bytes()
    with pytest.raises(LinkError, match="newer homebot"):
        await Kept(path).write("two")
    assert path.read_bytes() == before
