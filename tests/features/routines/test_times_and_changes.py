"""Routines that start again and again or with any change, and conditions about how long something has been so."""

import json

import pytest
from tests.apps.houses import hall
from tests.features.routines.test_routine import config

from homebot.devices.app_messages import ListRoutines, RoutinesRequest
from homebot.devices.names import LIST_ROUTINES
from homebot.graph import Node
from homebot.testing import virtual_house_of

PLACE = {"zone": "UTC", "latitude": 48.0, "longitude": 8.0}

COUNT: dict[str, object] = {
    "name": "Count",
    "when": ["every 25m"],
    "do": ["size number 60", "wait 1m", "size number 61", "wait 1m", "size number 50"],
}

pytestmark = [pytest.mark.slow, pytest.mark.virtual_time, pytest.mark.rooms("homeassistant")]


@pytest.mark.parametrize(
    ("when", "condition", "until", "count"),
    [
        ("every 30m", "", "09:40", 3),
        ("at :15 every hour", "", "10:20", 3),
        ("every hour at :15", "the last run was over 90m ago", "11:20", 2),
        ("every 30m", "not run today", "09:40", 1),
        ("every 8h", "not run today", "08:15", 2),
        ("every 30m", "already run today", "10:00", 0),
        ("homebot starts", "", "10:00", 1),
        ("sun elevation above 9.5°", "", "12:00", 1),
        ("the sun falls below 5°", "", "12:00", 0),
        ("every 10m", "sun elevation below 9.5°", "09:05", 4),
        ("every 10m", "not sun elevation below 9.5° or before 8:15", "09:45", 7),
        ("hall motion changes", "", "10:00", 4),
        ("hall motion occupancy changes", "", "10:00", 4),
        ("size number changes from 61 to 50", "", "09:05", 2),
        ("size number changes from 60 to 50", "", "09:05", 0),
        ("every 10m", "number of size below number of limit", "09:05", 6),
        ("every 10m", "number of size above number of limit minus 99", "09:05", 6),
        ("every 10m", "not number of size below number of limit or after 9:00", "09:05", 1),
        ("number of size rises above number of limit minus 1", "", "09:05", 2),
        ("number of size falls below number of limit", "", "09:05", 2),
        ("number of size rises above number of limit minus 1 for 90s", "", "09:05", 2),
        ("number of size rises above number of limit minus 1 for 150s", "", "09:05", 0),
        ("number of nothing falls below number of limit", "", "09:05", 0),
        ("message on home/bell", "", "09:05", 4),
        ("message on home/bell with ring", "", "09:05", 1),
        ("message on home/bell with state.times = 2", "", "09:05", 1),
        ("message on home/bell", "not message on home/bell with ring", "09:05", 3),
        ("message on home/bell", "not message on home/bell with ''", "09:05", 4),
        ("every 10m", "hall motion clear for 25m", "08:59", 3),
        ("every 10m", "no motion in hall for 25m", "08:59", 3),
    ],
)
async def test_a_routine_runs_as_often_as_its_text_says(when: str, condition: str, until: str, count: int) -> None:
    """Somebody is in the hall from 8:01 to 8:02, and from 9:10 to 9:11; a bell rings, and another routine counts."""
    world = hall(("08:01", "hall"), ("08:02", "outside"), ("09:10", "hall"), ("09:11", "outside"))
    routine = {"name": "Often", "when": [when], "if": [condition] if condition else [], "do": ["wait 1s"]}
    given = config(routine, COUNT) | {"home": PLACE, "helpers": {"limit": 60, "size": 50}}
    async with virtual_house_of(world=world, config=given, start="2026-01-01 08:00") as house:
        await house.run_until("08:20:30")
        for payload in ("ring", '{"state": {"times": 2}}', '{"state": 2}', '{"state": {"times": 2'):
            await house.says("home/bell", payload)
            await house.run_for("5s")
        await house.run_until(until)
        async with Node(house.runtime.graph, "owner") as owner:
            listing = owner.create_client(ListRoutines, LIST_ROUTINES)
            found = next(one for one in (await listing.call(RoutinesRequest())).routines if one.name == "Often")
    ran = [note for note in found.notes if note.text == "ran"]
    assert len(ran) == count, found.notes


@pytest.mark.parametrize(
    ("when", "condition", "expected"),
    [
        ("sink unreachable", "", ["08:12"]),
        ("sink unreachable for 5m", "", ["08:17"]),
        ("sink unreachable for 2h", "", []),
        ("sink reachable", "", ["08:42"]),
        ("not sink unreachable", "", ["08:42"]),
        ("every 20m", "sink offline for 5m", ["08:20", "08:40"]),
        ("every 20m", "not sink unreachable", ["09:00"]),
    ],
)
async def test_a_device_that_cannot_be_reached_is_a_state(when: str, condition: str, expected: list[str]) -> None:
    """A sensor is known from 8:10 on, and is offline from 8:12 to 8:42; whether it is there at first starts nothing."""
    topics = {"state_topic": "home/sink", "availability_topic": "home/sink/at"}
    sensor = {"name": "Sink", "unique_id": "sink", "device_class": "moisture", **topics}
    routine = {"name": "Reach", "when": [when], "if": [condition] if condition else [], "do": ["notify Now"]}
    given = config(routine) | {"home": PLACE, "notify": {}}
    async with virtual_house_of(config=given, start="2026-01-01 08:00") as house:
        await house.run_until("08:10")
        await house.says("homeassistant/binary_sensor/sink/config", json.dumps(sensor))
        await house.says("home/sink/at", "online")
        for until, says in (("08:12", "offline"), ("08:42", "online"), ("09:01", "online")):
            await house.run_until(until)
            await house.says("home/sink/at", says)
        at = [f"{one.time:%H:%M}" for one in house.notifications]
    assert at == expected
