"""A week in the family's house, with a washer, a vacuum, a button and two phones, in which ten routines run."""

import asyncio
import json
import tomllib
from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import anyio
from tests.replay.recorded_days import MemorySink, history_of, recording_of
from tests.sizes import size

import homebot.house
from homebot.apps.notifier import Notification
from homebot.config import load_config, parse_settings
from homebot.devices.journal_messages import JournalEntry
from homebot.devices.names import JOURNAL_ENTRIES
from homebot.features.routines.checks import asked_about
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.trial import routines_of
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.recording.recording import Recording
from homebot.support.virtual_time import VirtualTimeLoop
from homebot.testing import VirtualHouse, virtual_house_of

ROUTINES = Path(__file__).parents[3] / "examples/11_routines/homebot.toml"
_HOUSE = Path(homebot.house.__file__).parent / "family/house.toml"
_START = "2026-01-09"
"""A Friday."""

_ANNOUNCED: Mapping[str, dict[str, object]] = {
    "event/button": {
        "name": "hall button",
        "state_topic": "button",
        "device_class": "button",
        "event_types": ["single", "double", "hold"],
    },
    "vacuum/vacuum": {
        "name": "vacuum",
        "command_topic": "vacuum/do",
        "state_topic": "vacuum/is",
        "supported_features": ["start", "stop", "return_home"],
    },
    "device_tracker/kim": {"name": "Kim's phone", "state_topic": "kim"},
    "device_tracker/sam": {"name": "Sam's phone", "state_topic": "sam"},
    "sensor/washer": {"name": "washer", "state_topic": "washer", "device_class": "power", "unit_of_measurement": "W"},
}
_DAY: tuple[tuple[str, str, str], ...] = (
    ("00:00", "washer", "1"),
    ("00:00", "kim", "home"),
    ("00:00", "sam", "home"),
    ("07:30", "kim", "not_home"),
    ("07:45", "sam", "not_home"),
    ("09:00", "washer", "400"),
    ("09:20", "washer", "3"),  # a pause of the program
    ("09:21", "washer", "900"),
    ("10:30", "washer", "2"),
    ("12:05", "kim", "home"),
    ("13:35", "kim", "not_home"),
    ("16:05", "sam", "home"),
    ("17:05", "kim", "home"),
    ("20:15", "button", '{"event_type": "single"}'),
    ("20:16", "button", '{"event_type": "hold"}'),
    ("20:30", "button", '{"event_type": "double"}'),
)
"""Messages of each day, by time and topic."""


class Week(NamedTuple):
    """A recorded week, what the history has of it, and the notifications of it."""

    recording: Recording
    history: Recording
    notifications: tuple[Notification, ...]


@lru_cache(maxsize=1)
def week() -> Week:
    """The week with the routines of the example; Friday and Saturday alone, except in ``make nightly``."""
    days = size(usual=2, nightly=7)
    sink = MemorySink()
    told: list[Notification] = []
    kept: list[Recording] = []
    given = load_config(ROUTINES)
    read = [parse_settings(RoutineSettings, one, given.source, name) for name, one in routines_of(given)]

    async def live() -> None:
        config = tomllib.loads(ROUTINES.read_text("utf-8")) | {"history": {"enabled": True}}
        async with (
            virtual_house_of(world=_family(), config=config, start=_START, observers=sink.observers()) as house,
            Node(house.runtime.graph, "owner") as owner,
            anyio.create_task_group() as tasks,
        ):
            began = house.now.timestamp()
            entries: list[JournalEntry] = []
            owner.create_subscription(JournalEntry, JOURNAL_ENTRIES, entries.append, 1000)
            for name, announced in _ANNOUNCED.items():
                await house.says(f"homeassistant/{name}/config", json.dumps(announced | {"unique_id": name}))
            tasks.start_soon(_vacuum, house)
            for _ in range(days):
                await _live_a_day(house)
            told.extend(house.notifications)
            kept.append(await history_of(house, began, entries, asked_about(read)))
            tasks.cancel_scope.cancel()

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    return Week(recording_of(sink.lines), kept[0], tuple(told))


def _family() -> World:
    house = tomllib.loads(_HOUSE.read_text("utf-8"))
    del house["house"]["pace"], house["house"]["begins"]  # a day takes a day
    return parse_world(house, "family")


async def _live_a_day(house: VirtualHouse) -> None:
    midnight = house.now
    events = [*((at, topic, text) for at, topic, text in _DAY), ("19:40", "door", "open"), ("19:50", "door", "")]
    for at, topic, text in sorted(events):
        hours, minutes = map(int, at.split(":"))
        moment = midnight.replace(hour=hours, minute=minutes)
        if moment > house.now:
            await house.run_until(moment)
        if topic == "door":
            await house.sense("front_door", is_open=bool(text))
        else:
            await house.says(topic, text)
    await house.run_until("00:00")


async def _vacuum(house: VirtualHouse) -> None:
    """Obey as a vacuum does."""
    states: dict[str, Any] = {"start": "cleaning", "return_to_base": "docked", "stop": "idle"}
    await house.says("vacuum/is", json.dumps({"state": "docked"}))
    while True:
        command = await house.hears("vacuum/do", within="30d")
        await house.says("vacuum/is", json.dumps({"state": states[command]}))
