"""The search for habits in a week of a house of 200 devices, and for how long the event loop waits for it meanwhile.

The history and the journal are files, read by their own services. The baseline is the same loop without the search.
"""

from __future__ import annotations

import asyncio
import tempfile
import time
from collections.abc import Awaitable, Callable, Iterator
from pathlib import Path
from random import Random

import anyio
import anyio.lowlevel

from directory import sighting
from homebot.cli.serve import short_collections
from homebot.clock import LoopClock
from homebot.config import HomeSettings
from homebot.devices import Sighting
from homebot.devices.command_messages import Setting
from homebot.devices.journal_messages import ReadJournal
from homebot.devices.names import READ_JOURNAL
from homebot.devices.part import Capability, Part
from homebot.discovery import DeviceIndex, Directory, DirectorySettings
from homebot.discovery.owner_facts import OwnerFacts
from homebot.features.habits import SUGGEST_HABITS
from homebot.features.habits.habit_services import HabitServices
from homebot.features.habits.messages import SuggestHabits, SuggestHabitsRequest
from homebot.features.history.batch import Batch, Series, StateRow
from homebot.features.history.history import HistoryKeeper
from homebot.features.history.history_file import HistoryFile
from homebot.features.history.settings import HistorySettings
from homebot.graph import Graph, Node
from homebot.journal.file_store import FileStore
from homebot.journal.journal_file import JournalFile
from homebot.journal.store import JournalNote
from plan import Plan
from report import Report, milliseconds, seconds, verdict
from rounds import median

__all__ = ["run"]

ROOMS, LAMPS_OF_ROOM, SENSORS_OF_ROOM = 20, 5, 5
DAYS = 7
DAY = 86_400.0
CHANGES_OF_SENSOR = 60
"""A day."""

SWITCHED = 6
"""Times a day that each lamp is switched by hand, and as often by an app."""

TICK = 0.002
TIMES = 3
AIM, HELD = 10.0, 0.025
TITLE = f"Habits: a week of {ROOMS * (LAMPS_OF_ROOM + SENSORS_OF_ROOM)} devices"
HEADINGS = ("event loop", "longest wait, median", "p99", "aim", "search", "processor", "aim")
MEGABYTE = 1e6


def run(plan: Plan) -> Report:
    with tempfile.TemporaryDirectory() as folder, short_collections():
        changes = _write(Path(folder), now := time.time())
        rows = asyncio.run(_rows(Path(folder), now, plan.rounds(TIMES)))
    return Report(f"{TITLE}, {changes:,} changes", (), (), [HEADINGS, *rows])


async def _rows(folder: Path, now: float, times: int) -> list[tuple[str, ...]]:
    graph = Graph(LoopClock(now))
    async with Node(graph, "discovery") as node, Node(graph, "journal") as journal, Node(graph, "history") as history:
        directory = Directory(node, DirectorySettings(persist=False), owner=OwnerFacts("Home"))
        _announce_all(directory.index, graph.clock.monotonic())
        node.create_task(directory.serve)
        store = FileStore(journal, folder / "journal", 60 * DAY, 100 * MEGABYTE, 1000)
        journal.create_service(ReadJournal, READ_JOURNAL, store.read, concurrent=True)
        async with anyio.create_task_group() as tasks:
            await tasks.start(HistoryKeeper(history, HistorySettings(), folder / "history").serve)
            searched = [await _measured(graph, True) for _ in range(times)]
            idle = [await _measured(graph, False, one[2]) for one in searched]
            tasks.cancel_scope.cancel()
        return [_row("idle", idle), _row("while habits are searched", searched)]


def _row(name: str, found: list[tuple[float, float, float, float]]) -> tuple[str, ...]:
    longest, p99, took, spent = (median(list(one)) for one in zip(*found, strict=True))
    row = name, milliseconds(longest), milliseconds(p99)
    if name == "idle":
        return (*row, "", "", "", "")
    held, whole = (verdict(one <= aim) for one, aim in ((longest, HELD), (took, AIM)))
    return (*row, f"<= 25 ms: {held}", seconds(took), seconds(spent), f"<= 10 s: {whole}")


async def _measured(graph: Graph, searches: bool, length: float = 0.0) -> tuple[float, float, float, float]:
    """Return the longest and the 99th percentile of the delays of a timer, and the length, also of the processor."""
    async with Node(graph, "apps") as node:
        home = HomeSettings(zone="Europe/Berlin", latitude=52.5, longitude=13.4)
        HabitServices(node, home, {}, anyio.lowlevel.checkpoint).serve(SUGGEST_HABITS.name)
        client = node.create_client(SuggestHabits, SUGGEST_HABITS.name)

        async def search() -> None:
            if not searches:
                return await asyncio.sleep(length)
            answer = await client.call(SuggestHabitsRequest(days=DAYS), timeout=300)
            assert answer.success, answer.message
            assert answer.searched > 1000
            return None

        began, spent = time.perf_counter(), time.process_time()
        delays = sorted(await _delays_during(search))
        took, spent = time.perf_counter() - began, time.process_time() - spent
        return delays[-1], delays[int(0.99 * len(delays))], took, spent


async def _delays_during(work: Callable[[], Awaitable[None]]) -> list[float]:
    """Return how late a timer was each time, without the time in which other processes had the processor."""
    delays: list[float] = []
    task = asyncio.ensure_future(work())
    while not task.done():
        due, own = time.perf_counter() + TICK, time.process_time()
        await asyncio.sleep(TICK)
        delays.append(min(time.perf_counter() - due, time.process_time() - own))
    await task
    return delays


def _write(folder: Path, now: float) -> int:
    """Write the week to the files of the history and the journal."""
    random, batch, notes = Random(7), Batch(), list[JournalNote]()
    for number, (key, _, capability, _) in enumerate(_devices(), 1):
        batch.new.append(Series(number, (key, "main", capability), ""))
        is_lamp = capability == "on_off"
        count = DAYS * 2 * (2 * SWITCHED if is_lamp else CHANGES_OF_SENSOR)
        times = sorted(now - random.uniform(0.0, DAYS) * DAY for _ in range(count))
        for turn, (at, until) in enumerate(zip(times, (*times[1:], now), strict=True)):
            batch.states[round(at * 1000), number] = StateRow(round(until * 1000), turn % 2)
            if is_lamp:
                notes += _notes(key, at, is_on=bool(turn % 2), by_hand=turn % 4 < 2)
    file = HistoryFile(folder / "history", HistorySettings().keep)
    file.open(now)
    file.write(batch, round(now * 1000))
    file.close()
    journal = JournalFile(folder / "journal")
    journal.open(now)
    journal.write(sorted(notes, key=lambda one: one.at), (), 0.0, 1000 * MEGABYTE)
    journal.close()
    return len(batch.states)


def _notes(device: str, at: float, *, is_on: bool, by_hand: bool) -> Iterator[JournalNote]:
    settings = (Setting.of("on_off", is_on),)
    if by_hand:
        yield JournalNote("changed", at, device, "main", settings=settings, cause="person")
        return
    command = f"c{at}"
    yield JournalNote("requested", at - 0.5, device, "main", command, "/night_guard", settings=settings)
    yield JournalNote("sent", at - 0.4, device, "main", command, "/night_guard")
    yield JournalNote("reported", at, device, "main", command, settings=settings, cause="command")


def _devices() -> Iterator[tuple[str, str, str, str]]:
    for room in range(ROOMS):
        for number in range(LAMPS_OF_ROOM):
            yield f"lamp_{room}_{number}", "light", "on_off", f"Room {room}"
        for number in range(SENSORS_OF_ROOM):
            kind, capability = ("contact_sensor", "contact") if number else ("occupancy_sensor", "occupancy")
            yield f"sensor_{room}_{number}", kind, capability, f"Room {room}"


def _announce_all(index: DeviceIndex, now: float) -> None:
    for key, kind, capability, room in _devices():
        able = Capability(name=capability, settable=capability == "on_off")
        part = Part(id="main", service_type=kind, capabilities=(able,), reads=(key,), writes=(f"{key}/set",))
        change: dict[str, object] = {"key": key, "name": key, "service_type": kind, "identifiers": (f"id:{key}",)}
        change |= {"parts": (part,), "area": room, "announced_on": f"x/{key}"}
        announced: Sighting = sighting(0, 0.0, confirmed=True).model_copy(update=change)
        index.observe(announced, now)
    index.pop_changes()
    index.sort()
