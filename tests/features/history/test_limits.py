"""Limits of the history: a full disk, too many values, years that pass, and an event loop that goes on."""

import random
import sqlite3
import tomllib
from pathlib import Path

import anyio
import pytest
from tests.damage import damage
from tests.features.history.conftest import MIDNIGHT, MakeHouse
from tests.guide import blocks_in, guide
from tests.turns import Turns, longest_turn

from homebot.clock import LoopClock
from homebot.devices.health import HealthRequest
from homebot.devices.history_messages import ReadEnergyRequest, ReadHistoryRequest
from homebot.features.history.batch import Batch, Series
from homebot.features.history.collector import MAX_WAITING, Collector
from homebot.features.history.history import HistoryKeeper
from homebot.features.history.history_file import HistoryFile, HistoryStore
from homebot.features.history.settings import HistorySettings, KeepSettings
from homebot.graph import Graph, Node
from homebot.messages import Time

HOUR = 3_600_000
START = round(MIDNIGHT * 1000)
LONGEST_TURN = 0.05
"""Seconds of the processor of the reference machine."""


def counts(history: HistoryKeeper) -> dict[str, int]:
    return {one.name: one.count for one in history.health(HealthRequest()).counts}


def fill(connection: sqlite3.Connection) -> None:
    """Let the file have no page more, as on a full disk."""
    connection.execute("PRAGMA max_page_count = 1")


@pytest.mark.virtual_time
async def test_damage_that_is_found_while_reading_sets_the_file_aside(kept: MakeHouse, tmp_path: Path) -> None:
    async with kept() as house:
        await house.report("meter", energy=1.0)
        await anyio.sleep(600)
        damage(house.history._store.file)
        response = await house.response("meter", "energy")
        assert "is damaged" in response.message
        await anyio.sleep(600)
        assert (await house.response("meter", "energy")).success
    assert list(tmp_path.glob("history.sqlite.damaged-*"))


@pytest.mark.virtual_time
async def test_on_a_full_disk_values_wait_and_are_written_when_there_is_room_again(kept: MakeHouse) -> None:
    async with kept() as house:
        connection = house.history._store.file.connection
        fill(connection)
        chance = random.Random(1)  # noqa: S311 - values that take room
        values = [chance.uniform(10, 30) for _ in range(900)]
        for value in values:
            await house.report("thermometer", temperature=value)
            await anyio.sleep(2)
        health = house.history.health(HealthRequest())
        assert "database or disk is full" in health.troubles[0]
        assert counts(house.history)["history_failures"] > 1
        connection.execute("PRAGMA max_page_count = 1000000")
        await anyio.sleep(600)
        assert house.history.health(HealthRequest()).troubles == ()
        assert counts(house.history)["history_lost"] == 0
        series = await house.read("thermometer", since=3000, points=5000)
    assert {round(one, 3) for one in values} == {round(one, 3) for one in series.values}


@pytest.mark.virtual_time
async def test_of_more_values_than_may_wait_the_oldest_are_lost_and_counted(kept: MakeHouse) -> None:
    async with kept() as house:
        fill(house.history._store.file.connection)
        collector = house.history._collector
        await house.report("thermometer", temperature=1.0)
        followed = collector._followed["thermometer"]["", "temperature"]
        for number in range(2 * MAX_WAITING):
            collector._add(followed, START + number, float(number))
        await anyio.sleep(600)
        assert len(collector.batch.times) <= MAX_WAITING
        assert MAX_WAITING < counts(house.history)["history_lost"] < 1.1 * MAX_WAITING
        assert max(collector.batch.values) == 2 * MAX_WAITING - 1
        assert collector.batch.values[0] > MAX_WAITING - 1  # the newest are there


@pytest.mark.virtual_time
async def test_of_a_flood_of_presses_the_first_of_each_batch_are_kept_and_the_others_counted(kept: MakeHouse) -> None:
    async with kept() as house:
        for _ in range(2):
            for _ in range(100):
                await house.report("button", press="single")
                await anyio.sleep(1)
            await anyio.sleep(600)
        assert len((await house.read("button")).words) == 120
        assert counts(house.history)["history_folded"] == 80


def test_after_a_month_only_hours_become_more(tmp_path: Path) -> None:
    """Values of two days, summaries of thirty; a row a day for ever; words of a year."""
    file = HistoryFile(tmp_path / "history.sqlite", KeepSettings())
    file.open(0.0)
    file.load()
    batch = Batch(new=[Series(1, ("meter", "", "power"), "W")])
    for hour in range(40 * 24):
        at = START + hour * HOUR
        batch.add(1, at, float(hour))
        file.write(batch, at + HOUR - 1)
        batch = Batch()
    rows = {table: _count(file.connection, table) for table in ("recent", "raw", "five", "day")}
    (free,) = file.connection.execute("PRAGMA freelist_count").fetchone()
    (pages,) = file.connection.execute("PRAGMA page_count").fetchone()
    file.close()
    assert rows == {"recent": 1, "raw": 48, "five": 30 * 24, "day": 39}
    assert free <= pages / 4


def _count(connection: sqlite3.Connection, table: str) -> int:
    return int(connection.execute(f"SELECT count(*) FROM {table}").fetchone()[0])  # noqa: S608 - our own names


@pytest.mark.no_cover
async def test_the_loop_goes_on_while_a_hundred_thousand_values_are_written(tmp_path: Path) -> None:
    async def write(turns: Turns) -> None:
        (tmp_path / "history.sqlite").unlink(missing_ok=True)
        async with Node(Graph(), "history") as node:
            store = HistoryStore(node, tmp_path / "history.sqlite", HistorySettings())
            assert await store.open() is not None
            collector = Collector(LoopClock(), 1000, {}, {})
            now = round(LoopClock().now() * 1000)
            collector.batch.new += [Series(one, (f"s{one}", "", "power"), "W") for one in range(100)]
            for number in range(MAX_WAITING):
                collector.batch.add(number % 100, now - 7 * HOUR + number, float(number % 977))
            taken = 0
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(store.write, collector)
                turns.take()
                while collector.batch.new:
                    await anyio.sleep(0.001)
                    turns.take()
                    taken += 1
            assert store.kept.problem == ""
            assert taken > 5
            await store.kept.close()

    assert 0 < await longest_turn(write, limit=LONGEST_TURN) < LONGEST_TURN


@pytest.mark.virtual_time
async def test_a_question_about_all_time_reads_no_more_than_what_is_stored(kept: MakeHouse) -> None:
    """A client that may only read could otherwise keep the file busy for hours, and values would be lost meanwhile."""
    async with kept() as house:
        for hour in range(30):
            await house.report("meter", energy=float(hour), power=float(hour))
            await anyio.sleep(3600)
        statements: list[str] = []
        house.history._store.file.connection.set_trace_callback(statements.append)
        always = Time.from_seconds(-(2.0**31)), Time.from_seconds(2.0**31 - 1)
        energy = await house.history._service.energy(ReadEnergyRequest(since=always[0], until=always[1]))
        power = await house.history._service.read(ReadHistoryRequest(device="meter", since=always[0], until=always[1]))
    assert sum(day.used for day in energy.days) == 29.0
    assert [len(one.times) for one in power.series] == [1, 1]
    assert len(statements) < 500


async def test_devices_that_are_gone_leave_room_for_new_ones() -> None:
    gone = {(f"gone{one}", "", "power"): Series(one, (f"gone{one}", "", "power"), "W") for one in range(1, 11)}
    collector = Collector(LoopClock(), 10, gone, {})
    for one in range(12):
        collector._record(f"new{one}", "", "power", 1.0, START)
    assert (len(collector.series), collector.left_out) == (20, 2)
    assert sorted(one.number for one in collector.series.values()) == list(range(1, 21))


def test_the_configuration_guide_shows_the_defaults() -> None:
    tables = [tomllib.loads(block) for block in blocks_in(guide("configuration"), "toml")]
    (history,) = [table["history"] for table in tables if "history" in table]
    assert HistorySettings.model_validate(history) == HistorySettings()
