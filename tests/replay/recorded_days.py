"""Days that are recorded in virtual time, and their replays: for tests that need the rooms they name.

The features that record, and that tell differences, are loaded when a test uses them.
"""

import asyncio
import tomllib
from collections.abc import AsyncIterator, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import anyio
from tests.apps.houses import flat, lamp, motion

from homebot.config import parse_config
from homebot.devices import FIND_DEVICES, Device, FindDevices
from homebot.devices.device import part_names
from homebot.devices.history_messages import MAX_POINTS, HistorySeries, ReadHistory, ReadHistoryRequest
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import READ_HISTORY
from homebot.devices.services import FindDevicesRequest
from homebot.feature import load
from homebot.feature_context import RunObserver
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.messages import Time
from homebot.messages.std_srvs import Trigger, TriggerRequest
from homebot.recording.recording import Recording, read_recording
from homebot.replay.replay import Replayed, replay, replay_config
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing import VirtualHouse, virtual_house_of

if TYPE_CHECKING:
    from homebot.features.recording.command_diff import CommandDiff

FAMILY = (Path(__file__).parents[2] / "examples" / "houses" / "family.toml").read_text("utf-8")
APPS = {
    "light_service": {"class": "homebot.apps.light_service:LightService"},
    "lights_out": {"class": "homebot.apps.lights_out:LightsOut"},
    "window_heating": {"class": "homebot.apps.window_heating:WindowHeating"},
    "follow_me": {"class": "homebot.apps.follow_me:FollowMe"},
}


async def history_of(
    house: VirtualHouse, since: float, commands: Sequence[JournalEntry], is_wanted: Callable[[Device], bool]
) -> Recording:
    """The time from *since* on as a recording, made of the history of the devices that are wanted."""
    until = house.now.timestamp()
    begin, end = Time.from_seconds(since), Time.from_seconds(until)
    async with Node(house.runtime.graph, "historian") as node:
        devices = (await node.create_client(FindDevices, FIND_DEVICES).call(FindDevicesRequest())).devices
        history = node.create_client(ReadHistory, READ_HISTORY)
        series: list[HistorySeries] = []
        for device in filter(is_wanted, devices):
            asked = ReadHistoryRequest(device=device.id, points=MAX_POINTS, since=begin, until=end)
            answer = await history.call(asked)
            assert answer.success, answer.message
            series += answer.series
    history_recording = load("homebot.features.routines.history_recording:history_recording")
    recording: Recording = history_recording("home425", devices, series, commands, since, until)
    return recording


class MemorySink:
    """Keeps the lines of a recording."""

    is_full = False

    def __init__(self) -> None:
        self.lines: list[str] = []

    async def write(self, lines: Sequence[str]) -> None:
        self.lines += lines

    def observers(self) -> Mapping[str, RunObserver]:
        """What records a run into it."""
        return {"recorder": load("homebot.features.recording.recording_server:recorder_into")(self)}


def family(seed: int) -> World:
    """The family home; its devices announce themselves as for Home Assistant, those that can."""
    house = tomllib.loads(FAMILY)
    house["house"]["dialect"] = "homeassistant"
    house["devices"]["robot"]["dialect"] = "thesis"
    return parse_world(house, "family.toml", seed=seed)


def evening_flat() -> World:
    """A flat in which Anna is in the study for an hour of the evening, and in the kitchen for half of the next."""
    return flat(
        ("18:00", "study"),
        ("19:00", "kitchen"),
        ("19:30", "outside"),
        hall_lamp=lamp("hall"),
        study_lamp=lamp("study"),
        kitchen_lamp=lamp("kitchen"),
        hall_motion=motion("hall"),
        study_motion=motion("study"),
        kitchen_motion=motion("kitchen"),
    )


def recorded(
    world: World,
    apps: Sequence[str],
    length: str,
    *,
    seed: int = 1,
    start: str = "2026-01-01",
    config: Mapping[str, object] | None = None,
) -> Recording:
    """A recording of *world* from *start* on."""
    sink = MemorySink()
    tables = {**(config or {}), "apps": {name: APPS[name] for name in apps}}

    async def live() -> None:
        async with virtual_house_of(
            world=world, seed=seed, start=start, config=tables, observers=sink.observers()
        ) as home:
            await home.run_for(length)

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    return recording_of(sink.lines)


@asynccontextmanager
async def recorded_for_client(node: Node, lines: list[str]) -> AsyncIterator[None]:
    """Record into *lines* for the time of the block, as ``homebot record`` does."""
    read_recording = load("homebot.features.recording.session:ReadRecording")
    assert (await node.create_client(Trigger, "/homebot/start_recorder").call(TriggerRequest())).success
    reader = node.create_client(read_recording, "/homebot/recorder/read")
    is_last = anyio.Event()

    async def read() -> None:
        is_over = False
        while not is_over:
            answer = await reader.call(read_recording.Request(is_last=is_last.is_set()))
            lines.extend(answer.lines)
            is_over = answer.is_over

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(read)
        yield
        is_last.set()


def recording_of(lines: Sequence[str]) -> Recording:
    return read_recording([one.encode() for one in lines], "day.jsonl")


def replayed(recording: Recording, apps: Sequence[str] = (), tables: Mapping[str, object] | None = None) -> Replayed:
    """A replay with other *apps*, or with other *tables* of the configuration."""
    given = None if tables is None else parse_config(tables, "changes")
    config = replay_config(recording, apps, given)
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        loop = runner.get_loop()
        assert isinstance(loop, VirtualTimeLoop)
        return runner.run(replay(recording, config, loop.settled))


def diff_of(
    recording: Recording, apps: Sequence[str] = (), tables: Mapping[str, object] | None = None
) -> "CommandDiff":
    """The difference of such a replay."""
    found = replayed(recording, apps, tables)
    assert found.crashes == {}
    return difference(recording, found)


def difference(recording: Recording, found: Replayed) -> "CommandDiff":
    """The difference of *found*, a replay."""
    command_diff = load("homebot.features.recording.command_diff:command_diff")
    diff: CommandDiff = command_diff(recording.commands, found.commands, found.issuers, recording.ends_at)
    return diff


def texts(recording: Recording, diff: "CommandDiff") -> list[str]:
    """The differences as `homebot replay --diff` prints them."""
    names = part_names(recording.devices.values())
    start = recording.header.started_at.to_seconds()
    difference_text = load("homebot.features.recording.command_replay:difference_text")
    return [difference_text(one, start, names) for one in diff.different]
