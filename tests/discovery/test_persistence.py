"""The directory and its file, over restarts; with a real file, so in real time."""

import sqlite3
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from structlog.testing import capture_logs
from tests.discovery.announcements import announce, part_of
from tests.patience import PATIENCE
from tests.turns import Turns, longest_turn

from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import DISCOVERY_HEALTH
from homebot.discovery import Directory, DirectorySettings
from homebot.discovery.index import DeviceIndex
from homebot.discovery.persistence import IndexPersistence
from homebot.graph import Graph, Node
from homebot.testing import FakeGateway


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "index.sqlite"


@asynccontextmanager
async def directory_with(path: Path, graph: Graph | None = None, **settings: object) -> AsyncIterator[Directory]:
    async with Node(graph or Graph(), "discovery") as node, anyio.create_task_group() as tasks:
        directory = Directory(node, DirectorySettings.model_validate(settings), path)
        await tasks.start(directory.serve)
        yield directory
        tasks.cancel_scope.cancel()


async def test_devices_outlive_a_restart_unconfirmed(path: Path) -> None:
    """What was removed does not come back."""
    async with directory_with(path) as directory:
        directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp", confirmed=True))
        gone = announce("m", part_of(id="l"), ids=("id:gone",), name="Gone")
        directory.index.observe(gone)
        directory.index.observe(gone.model_copy(update={"kind": "removed"}))
    async with directory_with(path) as directory:
        assert [(one.id, one.freshness) for one in directory.index.devices()] == [("lamp", "unconfirmed")]
        assert len(directory.index.tombstones) == 1


async def test_what_the_owner_decided_on_merging_outlives_a_restart(path: Path) -> None:
    """Also where nothing else changed since the file was written."""
    lamp = part_of("light", "on_off", id="l")
    sightings = [announce(one, lamp, ids=("mac:aabbccddeeff",), gateway=one, name=one) for one in ("radio", "cable")]
    async with directory_with(path) as directory:
        for sighting in sightings:
            directory.index.observe(sighting)
        assert len(directory.index) == 1
        directory.index.split("radio", None, 0.0)
        directory.index.table.unsaved.clear()
    path_is_of = sqlite3.connect(path)
    assert path_is_of.execute("SELECT name FROM owner").fetchall() == [("merging",)]
    path_is_of.close()
    async with directory_with(path) as directory:
        for sighting in sightings:
            directory.index.observe(sighting)
        assert len(directory.index) == 2


async def test_the_thesis_layout_outlives_it_as_well(path: Path) -> None:
    graph = Graph()
    async with Node(graph, "fake", namespace="/gateway") as node, directory_with(path, graph):
        FakeGateway(node).sees("lights/lamp")
        await anyio.wait_all_tasks_blocked()
    async with directory_with(path) as directory:
        assert [one.id for one in directory.index.devices("light")] == ["lights/lamp"]


async def test_the_first_run_tells_of_no_last_one(path: Path) -> None:
    with capture_logs() as lines:
        async with directory_with(path) as directory:
            directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",)))
    assert [line for line in lines if "last run" in line.get("message", "")] == []
    with capture_logs() as lines:
        async with directory_with(path):
            pass
    assert "devices known from the last run: 1" in [line.get("message") for line in lines]


async def test_without_persistence_no_file_is_made(path: Path) -> None:
    async with directory_with(path, persist=False) as directory:
        directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",)))
    assert not path.exists()


async def test_a_damaged_file_is_told_and_what_is_known_goes_into_a_new_one(path: Path) -> None:
    path.write_bytes(b"rubbish" * 1000)
    with capture_logs() as lines:
        async with directory_with(path) as directory:
            directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp"))
    assert "file.damaged" in [line["event"] for line in lines]
    assert len(list(path.parent.glob("*.damaged-*"))) >= 1
    async with directory_with(path) as directory:
        assert len(directory.index) == 1


async def test_a_file_that_is_removed_while_it_is_used_is_written_anew_with_all_that_is_known(path: Path) -> None:
    """What is written into a file that no folder has any more is gone with the run.

    A record of the owner for a feature that was taken out stays until it is back.
    """
    async with directory_with(path) as directory:
        directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp"))
        assert await directory.save_record("acme", "of the owner", at_once=True) == ""
    with capture_logs() as lines:
        async with directory_with(path) as directory:
            for file in path.parent.glob(f"{path.name}*"):
                file.unlink()
            directory.index.observe(announce("p", part_of(id="p"), ids=("id:plug",), name="Plug"))
    (line,) = [one for one in lines if one["event"] == "file.removed"]
    assert line["message"].endswith("a new one is begun; stop homebot before you move it")
    async with directory_with(path) as directory:
        assert sorted(one.id for one in directory.index.devices()) == ["lamp", "plug"]
        assert directory.owner_record("acme") == "of the owner"


async def test_records_that_make_no_sense_cost_themselves_alone(path: Path) -> None:
    async with directory_with(path) as directory:
        directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp"))
    with sqlite3.connect(path) as file:
        file.execute("INSERT INTO devices VALUES ('bad', '{}')")
        file.execute("INSERT INTO tombstones VALUES ('bad', '[1]')")
    file.close()
    with capture_logs() as lines:
        async with directory_with(path) as directory:
            assert [one.id for one in directory.index.devices()] == ["lamp"]
    assert "discovery.index_record_rejected" in [line["event"] for line in lines]


async def test_a_place_that_cannot_be_written_is_told_and_costs_no_device(path: Path) -> None:
    path.write_text("")
    with capture_logs() as lines:
        async with directory_with(path / "index.sqlite") as directory:
            directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp"))
            assert len(directory.index.devices()) == 1
    assert "file.not_written" in [line["event"] for line in lines]


async def test_a_device_that_no_file_can_hold_costs_itself_alone(path: Path) -> None:
    with capture_logs() as lines:
        async with directory_with(path) as directory:
            directory.index.observe(announce("bad", part_of(), ids=("id:half-a-pair",), name="\ud800"))
            directory.index.observe(announce("\ud800", name="A key is an id"))
            directory.index.observe(announce("good", part_of(), ids=("id:lamp",), name="Lamp"))
            directory.index.forget("homeassistant:\ud800", 1.0)
    assert "discovery.index_record_rejected" in [line["event"] for line in lines]
    async with directory_with(path) as directory:
        assert [one.id for one in directory.index.devices()] == ["lamp"]


async def test_a_file_that_cannot_be_written_is_a_trouble_for_those_who_ask(path: Path) -> None:
    graph = Graph()
    path.mkdir()
    async with Node(graph, "doctor") as doctor, directory_with(path, graph):
        client = doctor.create_client(GetHealth, DISCOVERY_HEALTH)
        (trouble,) = (await client.call(HealthRequest())).troubles
        assert "cannot be opened" in trouble


async def test_a_file_of_a_newer_homebot_is_not_used(path: Path) -> None:
    with sqlite3.connect(path) as file:
        file.execute("PRAGMA user_version = 99")
    file.close()
    with capture_logs() as lines:
        async with directory_with(path):
            pass
    assert "file.not_used" in [line["event"] for line in lines]


async def test_a_disk_that_has_room_again_is_written_within_ten_seconds(
    path: Path, pass_time: Callable[[float], None]
) -> None:
    graph = Graph()
    path.mkdir()
    with capture_logs() as lines:
        async with Node(graph, "doctor") as doctor, directory_with(path, graph) as directory:
            health = doctor.create_client(GetHealth, DISCOVERY_HEALTH)
            directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp"))
            assert (await health.call(HealthRequest())).troubles
            pass_time(10)  # it tries again, and fails again
            await anyio.sleep(0.1)
            path.rmdir()
            pass_time(10)
            with anyio.fail_after(PATIENCE):
                while (await health.call(HealthRequest())).troubles:  # noqa: ASYNC110 - a thread of SQLite tells nobody
                    await anyio.sleep(0.01)
            assert "file.written_again" in [line["event"] for line in lines]
            assert path.is_file()


async def test_what_could_not_be_written_is_written_when_it_can_be(path: Path) -> None:
    """As with a full disk: here a folder stands where the file should be."""
    path.mkdir()
    with capture_logs() as lines:
        async with directory_with(path) as directory:
            directory.index.observe(announce("l", part_of(id="l"), ids=("id:lamp",), name="Lamp"))
            assert "lamp" in directory.index.table.unsaved
            path.rmdir()
    assert [line["event"] for line in lines if line["event"].startswith("file.")] == [
        "file.not_written",
        "file.written_again",
    ]
    async with directory_with(path) as directory:
        assert [one.id for one in directory.index.devices()] == ["lamp"]


@pytest.mark.no_cover
async def test_others_get_their_turns_while_devices_with_many_parts_are_written(path: Path) -> None:
    """Nobody waits longer than 50 ms, whatever the devices of one transaction have."""
    parts = [part_of("light", "on_off", "brightness", id=f"part-{number}") for number in range(100)]

    async def write(turns: Turns) -> None:
        path.unlink(missing_ok=True)
        async with Node(Graph(), "discovery") as node, anyio.create_task_group() as others:
            index = DeviceIndex(forget_after=60)
            file = IndexPersistence(node, index, path)
            await file.load()
            for number in range(100):
                index.observe(announce(f"d{number}", *parts, ids=(f"id:device-{number}",)))
            others.start_soon(turns.take_all)
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(file.run)
                await anyio.sleep(0.01)
                tasks.cancel_scope.cancel()  # it writes at its end
            others.cancel_scope.cancel()

    assert 0 < await longest_turn(write, limit=0.05) < 0.05
    async with directory_with(path) as directory:
        assert [len(one.parts) for one in directory.index.devices()] == [100] * 100
