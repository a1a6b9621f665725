"""The family of the examples lives for a week; nobody is said to have the habits of its devices and apps."""

from datetime import timedelta

import pytest
from tests.replay.recorded_days import APPS, family

from homebot.config import parse_config
from homebot.features.habits import SUGGEST_HABITS
from homebot.features.habits.messages import SuggestHabits, SuggestHabitsRequest
from homebot.graph import Node
from homebot.testing import virtual_house_of

pytestmark = [pytest.mark.virtual_time, pytest.mark.slow, pytest.mark.rooms("homeassistant", "thesis")]

# What is searched is kept by homebot.features.history.
CONFIG = parse_config(
    {"history": {"enabled": True}, "home": {"zone": "UTC", "latitude": 52.5, "longitude": 13.4}, "apps": APPS}, "test"
)


async def test_what_devices_do_by_their_own_programs_is_nobodys_habit() -> None:
    """Covers and thermostats with daily programs do it at the same second, which looks like a hand otherwise."""
    async with virtual_house_of(world=family(7), config=CONFIG, start="2026-01-05") as house:
        await house.run_until(house.now + timedelta(days=7))
        async with Node(house.runtime.graph, "owner") as node:
            client = node.create_client(SuggestHabits, SUGGEST_HABITS.name)
            answer = await client.call(SuggestHabitsRequest(), timeout=600)
    assert answer.success, answer.message
    assert answer.searched > 1000
    found = {habit.name for habit in answer.proposals}.union(answer.watched)
    assert [name for name in found if name.startswith("bedroom_lamp on at 06:")]  # how its people begin the day
    assert not [name for name in found if "_cover " in name or "_heat " in name], found
