"""The journal in a file: over a restart, bounded, and without a disk."""

import shutil
import sqlite3
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, closing
from pathlib import Path

import anyio
import anyio.lowlevel
import pytest
from structlog.testing import capture_logs
from tests.patience import PATIENCE

from homebot.clock import ManualClock
from homebot.control import Control
from homebot.devices.access_messages import AccessRefused
from homebot.devices.command_messages import Setting
from homebot.devices.journal_messages import JournalEntry, ReadJournalRequest
from homebot.devices.names import ACCESS_REFUSALS, JOURNAL_ENTRIES
from homebot.devices.value import Value
from homebot.graph import Graph, Node
from homebot.journal.file_store import FileStore
from homebot.journal.store import JournalNote, LearntRow
from homebot.messages import Time

DAY = 86_400.0
NOW = 1_800_000_000.0


def note(number: int, *, device: str = "lamp", at: float = NOW) -> JournalNote:
    setting = Setting(capability="level", value=Value.of(float(number)))
    return JournalNote("requested", at, device, command=f"c-{number}", settings=(setting,))


def entry(number: int) -> JournalEntry:
    return note(number).entry()


@asynccontextmanager
async def opened(
    path: Path, days: float = 30.0, most_bytes: float = 1e9, most_waiting: int = 10_000
) -> AsyncIterator[FileStore]:
    async with Node(Graph(ManualClock(NOW)), "control") as node, anyio.create_task_group() as tasks:
        store = FileStore(node, path, days * DAY, most_bytes, most_in_memory=100, most_waiting=most_waiting)
        tasks.start_soon(store.run)
        yield store
        tasks.cancel_scope.cancel()
        await store.close()


async def read(store: FileStore, **request: object) -> tuple[JournalEntry, ...]:
    found = await store.read(ReadJournalRequest.model_validate(request))
    assert found.success, found.message
    return found.entries


async def test_what_was_noted_is_there_after_a_restart(tmp_path: Path) -> None:
    notes = [note(number, device=f"lamp{number % 2}") for number in range(10)]
    entries = [one.entry() for one in notes]
    async with opened(tmp_path / "journal.sqlite") as store:
        for one in notes:
            store.add(one)
        assert await read(store) == tuple(entries)  # those not written yet among them
        store.add(note(10))
    async with opened(tmp_path / "journal.sqlite") as store:
        assert await read(store) == (*entries, entry(10))
        assert await read(store, device="lamp1") == tuple(entries[1::2])
        assert await read(store, command="c-3") == (entries[3],)
        assert await read(store, limit=3) == (*entries[-2:], entry(10))


async def test_the_entries_of_the_devices_of_a_room_are_read_at_once_also_before_they_are_written(
    tmp_path: Path,
) -> None:
    notes = [note(number, device=f"lamp{number % 3}") for number in range(9)]
    async with opened(tmp_path / "j") as store:
        for one in notes[:6]:
            store.add(one)
    async with opened(tmp_path / "j") as store:
        for one in notes[6:]:
            store.add(one)
        found = await read(store, devices=("lamp0", "lamp2", "tv"))
    assert [one.command for one in found] == ["c-0", "c-2", "c-3", "c-5", "c-6", "c-8"]


async def test_a_home_without_entries_has_no_file(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite"):
        await anyio.lowlevel.checkpoint()
    assert not (tmp_path / "journal.sqlite").exists()


async def test_old_entries_are_dropped_and_counted(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", days=2) as store:
        store.add(note(0, at=NOW - 3 * DAY))
        store.add(note(1, at=NOW - 1 * DAY))
        assert await read(store) == (note(1, at=NOW - 1 * DAY).entry(),)
        assert store.dropped == 1


async def test_the_file_does_not_grow_without_end(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", most_bytes=200_000) as store:
        for number in range(5000):
            store.add(note(number))
            if number % 500 == 499:
                await read(store, limit=1)
        kept = await read(store)
        assert kept[-1] == entry(4999)
        assert 0 < store.dropped < 5000
        assert (tmp_path / "journal.sqlite").stat().st_size < 600_000


async def test_a_disk_that_is_away_costs_nothing_that_fits_into_memory(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.write_text("in the way")
    async with opened(folder / "journal.sqlite") as store:
        store.add(note(1))
        found = await store.read(ReadJournalRequest())
        assert not found.success
        assert "cannot be opened" in found.message
        assert store.problem
        folder.unlink()
        assert await read(store) == (entry(1),)
        assert not store.problem


async def test_what_cannot_be_written_now_is_read_all_the_same(tmp_path: Path) -> None:
    """A full disk would else make changes of commands those of a hand."""
    path = tmp_path / "journal.sqlite"
    async with opened(path) as store:
        store.add(note(1))
    with closing(sqlite3.connect(path)) as connection:
        fails = "SELECT abs(-9223372036854775808)"  # an error of the statement, as a full disk is one
        connection.execute(f"CREATE TRIGGER full BEFORE INSERT ON entries BEGIN {fails}; END")
        connection.commit()
    async with opened(path) as store:
        store.add(note(2, device="plug"))
        store.add(note(3))
        assert await read(store) == (entry(1), note(2, device="plug").entry(), entry(3))
        assert store.problem
        assert await read(store, device="lamp") == (entry(1), entry(3))
        assert await read(store, command="c-2") == (note(2, device="plug").entry(),)
        assert await read(store, limit=2) == (note(2, device="plug").entry(), entry(3))
        found = await store.read(ReadJournalRequest(limit=2))
        assert (found.complete, found.begins) == (False, entry(1).at)


async def test_a_damaged_file_is_set_aside(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    path.write_bytes(b"no database at all" * 100)
    path.chmod(0o600)
    async with opened(path) as store:
        store.add(note(1))
        assert await read(store) == (entry(1),)
        assert store.problem.startswith(f"the journal {path} was damaged; it was moved to ")
    assert len(list(tmp_path.glob("journal.sqlite.damaged-*"))) == 1


async def test_a_file_that_is_removed_while_it_is_used_is_begun_anew_and_told(tmp_path: Path) -> None:
    """What is written into a file that no folder has any more is gone with the run."""
    path = tmp_path / "home" / "journal.sqlite"
    with capture_logs() as lines:
        async with opened(path) as store:
            store.add(note(0))
            assert await read(store) == (entry(0),)
            shutil.rmtree(path.parent)
            store.add(note(1))
            assert await read(store) == (entry(1),)
            assert "was removed or replaced while homebot ran" in store.problem
            store.add(note(2))
        assert "was removed or replaced while homebot ran" in store.problem
    async with opened(path) as store:
        assert await read(store) == (entry(1), entry(2))
        assert store.problem == ""
    (line,) = [one for one in lines if one["event"] == "file.removed"]
    assert line["message"].endswith("a new one is begun; stop homebot before you move it")


async def test_a_file_of_a_newer_homebot_is_left_alone(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    async with opened(path) as store:
        store.add(note(0))
    with sqlite3.connect(path) as connection:
        connection.execute("PRAGMA user_version = 99")
    connection.close()
    before = path.read_bytes()
    async with opened(path) as store:
        store.add(note(1))
        assert await read(store) == (entry(1),)
        assert "newer homebot" in store.problem
    assert path.read_bytes() == before


async def test_a_row_that_makes_no_sense_costs_itself_alone(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    async with opened(path) as store:
        store.add(note(1))
        store.add(note(2))
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE entries SET entry = 'nonsense' WHERE number = 1")
    connection.close()
    async with opened(path) as store:
        assert await read(store) == (entry(2),)


def learnt(name: str, record: str = "{}", at: float = NOW) -> LearntRow:
    return LearntRow("witness", name, record, at)


async def test_what_was_learnt_is_there_after_a_restart(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite") as store:
        assert await store.learnt() == ()
        store.learn(learnt("lamp", "1"))
        store.learn(learnt("lamp", "2", NOW + 1))
        store.learn(learnt("plug"))
    async with opened(tmp_path / "journal.sqlite") as store:
        assert await store.learnt() == (learnt("plug"), learnt("lamp", "2", NOW + 1))
        store.learn(learnt("plug", ""))
    async with opened(tmp_path / "journal.sqlite") as store:
        assert await store.learnt() == (learnt("lamp", "2", NOW + 1),)


async def test_what_was_not_learnt_again_for_long_is_dropped(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", days=2) as store:
        store.learn(learnt("lamp", at=NOW - 3 * DAY))
        store.learn(learnt("plug", at=NOW - 1 * DAY))
    async with opened(tmp_path / "journal.sqlite", days=2) as store:
        assert await store.learnt() == (learnt("plug", at=NOW - 1 * DAY),)


async def test_what_was_learnt_takes_no_place_of_the_entries(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", most_bytes=200_000) as store:
        for number in range(100):
            store.learn(learnt(f"lamp{number}", "x" * 5000))
            store.add(note(number))
        assert len(await read(store)) == 100
        assert store.dropped == 0


async def test_a_file_of_before_anything_was_learnt_is_brought_up_to_date(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    async with opened(path) as store:
        store.add(note(1))
    with sqlite3.connect(path) as connection:
        connection.execute("DROP TABLE learnt")
        connection.execute("PRAGMA user_version = 1")
    connection.close()
    async with opened(path) as store:
        store.learn(learnt("lamp"))
        assert await read(store) == (entry(1),)
    async with opened(path) as store:
        assert await store.learnt() == (learnt("lamp"),)


async def test_a_damaged_row_of_what_was_learnt_has_no_record(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    async with opened(path) as store:
        store.learn(learnt("lamp"))
        store.learn(learnt("plug", at=NOW + 1))
    with sqlite3.connect(path) as connection:
        connection.execute("UPDATE learnt SET record = x'ff00' WHERE name = 'lamp'")
    connection.close()
    async with opened(path) as store:
        assert await store.learnt() == (learnt("lamp", ""), learnt("plug", at=NOW + 1))


async def test_a_flood_of_what_is_learnt_is_bounded_and_counted(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", most_waiting=10) as store:
        for number in range(25):
            store.learn(learnt(f"lamp{number}"))
            store.add(note(number))
        assert store.failures == 30
        assert await read(store) == tuple(entry(number) for number in range(15, 25))
        assert {one.name for one in await store.learnt()} == {f"lamp{number}" for number in range(15, 25)}


@pytest.mark.virtual_time
async def test_many_entries_are_written_before_their_time_so_that_none_is_lost(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", most_waiting=2000) as store:
        for second in range(10):
            for number in range(1000):
                store.add(note(1000 * second + number))
            await anyio.sleep(1)
        assert (store.failures, store.dropped) == (0, 0)
        assert len(await read(store, limit=1000)) == 1000


async def test_a_flood_while_the_disk_is_away_is_bounded_and_counted(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", most_waiting=10) as store:
        for number in range(25):
            store.add(note(number))
        assert store.failures == 15
        assert await read(store) == tuple(entry(number) for number in range(15, 25))


async def test_what_comes_while_the_file_is_opened_costs_the_oldest_alone(tmp_path: Path) -> None:
    async with opened(tmp_path / "journal.sqlite", most_waiting=10) as store:
        for number in range(10):
            store.add(note(number))
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(store.read, ReadJournalRequest())
            for number in range(10, 15):
                await anyio.lowlevel.checkpoint()
                store.add(note(number))
        found = await read(store)
        assert len(found) >= 10
        assert found == tuple(entry(number) for number in range(15 - len(found), 15))


async def test_what_the_door_refused_and_was_not_noted_yet_is_counted_at_a_stop(tmp_path: Path) -> None:
    path = tmp_path / "journal.sqlite"
    graph = Graph(ManualClock(NOW))
    async with Node(graph, "control") as node, Node(graph, "door") as door, anyio.create_task_group() as tasks:
        control = Control(node, journal_file=path)
        await tasks.start(control.serve)
        refusals = door.create_publisher(AccessRefused, ACCESS_REFUSALS, 100)
        entries = door.create_subscription(JournalEntry, JOURNAL_ENTRIES, qos_profile=100)
        for target in (*["/app/same"] * 30, "/app/last"):
            refusals.publish(refusal(target))
        with anyio.fail_after(PATIENCE):
            while (await entries.receive()).verdicts[0].facts[1].value.plain() != "/app/last":
                pass
        tasks.cancel_scope.cancel()
    async with opened(path) as store:
        found = await read(store)
    counts = [one.verdicts[0].facts[4].value.plain() for one in found]
    assert counts == [1.0, 1.0, 29.0]
    assert found[-1].verdicts[0].facts[1].value.plain() == "/app/same"


def refusal(target: str) -> AccessRefused:
    return AccessRefused(
        issuer="client:tv",
        address="127.0.0.1:4",
        operation="call_service",
        target=target,
        right="act",
        reason="the right act is missing",
        refused_at=Time.from_seconds(NOW),
    )
