"""Each form of triggers, conditions and steps is run, explained, told by why, tried and exported."""

import asyncio
import gzip
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

import pytest
from tests.apps.houses import hall
from tests.replay.recorded_days import MemorySink

from homebot.config import parse_config
from homebot.devices.app_messages import ListRoutines, RoutineInfo, RoutinesRequest
from homebot.devices.journal_messages import ReadJournal, ReadJournalRequest
from homebot.devices.names import LIST_ROUTINES, READ_JOURNAL
from homebot.features.routines.command_trial import trial_lines
from homebot.graph import Node
from homebot.recording.recording import load_recording
from homebot.testing import VirtualTimeLoop, virtual_house_of

pytestmark = [pytest.mark.slow, pytest.mark.rooms("homeassistant", "recording")]

HOME = {"zone": "UTC", "latitude": 48.0, "longitude": 8.0}
HELPERS = {"count": {"counter": 0}, "limit": 60, "vacation": False, "mode": ["day", "night"], "oven": {"timer": "5m"}}
HELPERS |= {"pause": 2, "bell": {"button": True}, "early": {"time": "07:10"}, "note": {"text": "none"}}

TRIGGERS = (
    *("every 30m", "at :15 every hour", "homebot starts", "8:20", "8:20 on 1 Jan", "8:20 from November to March"),
    *("message on home/bell", "message on home/bell with ring", "hall motion changes", "hall motion occupied"),
    *("no motion in hall for 5m", "sun elevation above 0°", "sunrise", "vacation changes", "oven press finished"),
    *("count number rises above 3", "number of count rises above number of limit minus 58"),
    *("mode option changes from day to night", "vacation on for 5m", "vacation on for {number of pause}m"),
    *("mode option changes from day to night for 5m", "bell press", "sun azimuth above 130°"),
)
CONDITIONS = (
    *("hall motion clear for 10m", "vacation off", "mode option = day", "sun elevation below 60°", "sun is up"),
    *("the last run was over 1m ago", "number of limit above number of count", "in January", "after 7:00"),
    *("started by every 10m", "not vacation on", "nobody in hall or vacation off"),
    *("vacation on for less than 12m", "chance 1 in 2", "sun azimuth below 170°", "after text of early"),
    *("not between text of early and 8:10", "vacation off for {number of pause}m"),
)
STEPS: tuple[object, ...] = (
    *("wait 10s", "wait {number of limit}s", "wait 5s to 20s", "wait for every 10m, at most 1m", "stop"),
    *(
        "wait until hall motion clear, at most 1m, then stop",
        "turn off routine Step 0",
        "oven number 5",
        "mode option night",
    ),
    *("wait until hall motion clear and until vacation on, at most 1m", "notify {names of hall lamp}", "bell press"),
    *("hall lamp on, {number of limit} %", "notify {routine} at {time}: {number of limit}", "vacation on"),
    {"if": ["vacation on"], "do": ["wait 1s"], "else": ["wait 2s"]},
    {"repeat": 2, "do": ["wait 1s"]},
    {"until": ["vacation on"], "do": ["wait 10s"]},
    {"while": ["vacation off"], "do": ["wait 10s"]},
)
COUNTED = "count number +1"
ROUTINES: Mapping[str, dict[str, object]] = {
    **{f"Trigger {place}": {"when": [text], "do": [COUNTED]} for place, text in enumerate(TRIGGERS)},
    **{
        f"Condition {place}": {"when": ["every 10m"], "if": [text], "do": [COUNTED]}
        for place, text in enumerate(CONDITIONS)
    },
    **{f"Step {place}": {"when": ["8:10"], "do": [COUNTED, step]} for place, step in enumerate(STEPS)},
}


class Hour(NamedTuple):
    """What the routines did in an hour: what is told of each, who counted, and the recording."""

    told: Mapping[str, RoutineInfo]
    counted_by: frozenset[str]
    recording: bytes


@cache
def hour() -> Hour:
    """An hour from 8:00 on the first of January, in which Anna looks into the hall and a bell rings."""
    sink, kept = MemorySink(), list[Hour]()
    config = {"home": HOME, "helpers": HELPERS, "routines": [{"name": name, **one} for name, one in ROUTINES.items()]}
    world = hall(("08:30", "hall"), ("08:31", "outside"))

    async def live() -> None:
        async with (
            virtual_house_of(world=world, config=config, start="2026-01-01 07:10", observers=sink.observers()) as house,
            Node(house.runtime.graph, "owner") as owner,
        ):
            await house.run_until("08:05")
            await house.says("home/bell", "ring")
            await house.run_until("09:00")
            listing = owner.create_client(ListRoutines, LIST_ROUTINES)
            told = {one.name: one for one in (await listing.call(RoutinesRequest())).routines}
            journal = await owner.create_client(ReadJournal, READ_JOURNAL).call(ReadJournalRequest(device="count"))
            by = frozenset(one.issuer for one in journal.entries)
            kept.append(Hour(told, by, gzip.compress("".join(f"{line}\n" for line in sink.lines).encode())))

    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        runner.run(live())
    return kept[0]


@pytest.mark.parametrize("name", ROUTINES)
def test_a_form_runs_and_is_explained_with_its_text_and_why_names_it(name: str) -> None:
    info = hour().told[name]
    assert (info.problem, list(info.when)) == ("", ROUTINES[name]["when"])
    assert [note.text for note in info.notes if note.text == "ran" or "stopped" in note.text], info.notes
    assert f"/{info.app}" in hour().counted_by


def test_all_forms_are_tried_on_the_hour_that_was_recorded(tmp_path: Path) -> None:
    (tmp_path / "hour.jsonl.gz").write_bytes(hour().recording)
    given = parse_config(
        {"home": HOME, "helpers": HELPERS, "routines": [{"name": name, **one} for name, one in ROUTINES.items()]},
        "test",
    )
    lines = trial_lines("hour", load_recording(tmp_path / "hour.jsonl.gz"), given)
    assert [name for name in ROUTINES if not any(name.lower().replace(" ", "_") in line for line in lines)] == []
