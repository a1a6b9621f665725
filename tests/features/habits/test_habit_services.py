"""Habits of the people in a running house are proposed, accepted, rejected and forgotten."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import timedelta

import pytest

from homebot.config import parse_config
from homebot.devices.app_messages import ChangeRoutineResponse, ListRoutines, RoutinesRequest
from homebot.devices.names import LIST_ROUTINES
from homebot.features.habits import DECIDE_HABIT, SUGGEST_HABITS
from homebot.features.habits.messages import (
    DecideHabit,
    DecideHabitRequest,
    HabitProposal,
    SuggestHabits,
    SuggestHabitsRequest,
    SuggestHabitsResponse,
)
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.support.toml_file import parse_toml
from homebot.testing import VirtualHouse, virtual_house_of

pytestmark = pytest.mark.virtual_time

DAYS = 14
# What is searched is kept by homebot.features.history.
CONFIG = parse_config(
    {"history": {"enabled": True}, "home": {"zone": "UTC", "latitude": 52.5, "longitude": 13.4}}, "test"
)


def world() -> World:
    text = """
[house]
by_hand = false
[rooms.hall]
[devices.hall_lamp]
kind = "lamp"
room = "hall"
[rooms.study]
[devices.desk_lamp]
kind = "lamp"
room = "study"
"""
    return parse_world(parse_toml(text, "test"), "test")


class Owner:
    """What the owner asks of the house."""

    def __init__(self, node: Node) -> None:
        self._suggest = node.create_client(SuggestHabits, SUGGEST_HABITS.name)
        self._decide = node.create_client(DecideHabit, DECIDE_HABIT.name)
        self._list = node.create_client(ListRoutines, LIST_ROUTINES)

    async def answer(self) -> SuggestHabitsResponse:
        return await self._suggest.call(SuggestHabitsRequest())

    async def proposals(self) -> dict[str, HabitProposal]:
        return {one.do: one for one in (await self.answer()).proposals}

    async def decide(self, habit: HabitProposal, *, accept: bool) -> ChangeRoutineResponse:
        return await self._decide.call(DecideHabitRequest(id=habit.id, accept=accept))

    async def routines(self) -> dict[str, bool]:
        return {one.steps[0]: one.of_habit for one in (await self._list.call(RoutinesRequest())).routines}


@asynccontextmanager
async def house_with_habits() -> AsyncIterator[tuple[VirtualHouse, Owner]]:
    """Two lamps that a person switches at the same times each day."""
    async with (
        virtual_house_of(world=world(), config=CONFIG, start="2026-01-05") as house,
        Node(house.runtime.graph, "owner") as node,
    ):
        for day in range(DAYS):
            midnight = house.now.replace(hour=0, minute=0, second=0)
            for hour, lamp, word in ((7, "hall_lamp", "on"), (9, "hall_lamp", "off"), (22, "desk_lamp", "on")):
                await house.run_until(midnight + timedelta(hours=hour, minutes=3 * (day % 4)))
                await house.press(lamp, word)
            await house.run_until(midnight + timedelta(hours=23.5))
            await house.press("desk_lamp", "off")
            await house.run_until(midnight + timedelta(days=1))
        yield house, Owner(node)


async def test_what_a_person_does_each_day_is_proposed_accepted_and_rejected() -> None:
    async with house_with_habits() as (_, owner):
        found = await owner.proposals()
        assert {one.partition(" ")[0] for one in found} == {"hall_lamp", "desk_lamp"}
        assert all(one.when[:2] in {"07", "09", "22", "23"} or one.when.startswith("sun") for one in found.values())
        morning, evening = found["hall_lamp on"], found["desk_lamp on"]
        assert morning.proof.endswith(" 7 of 7 times; a routine would be right 84 to 100 % of the time")

        answer = await owner.decide(morning, accept=True)
        assert answer.message.startswith(f"added {morning.name}")
        assert await owner.routines() == {"hall_lamp on": True}
        assert "never" not in (await owner.decide(evening, accept=False)).message
        left = await owner.proposals()
        assert not left.keys() & {"hall_lamp on", "desk_lamp on"}
        assert not (await owner.decide(evening, accept=True)).success
        assert await owner.routines() == {"hall_lamp on": True}


@pytest.mark.rooms("homeassistant")
async def test_what_a_person_does_after_a_press_that_starts_nothing_is_proposed() -> None:
    button = {"name": "Hall button", "unique_id": "b", "state_topic": "button", "event_types": ["single", "double"]}
    async with (
        virtual_house_of(world=world(), config=CONFIG, start="2026-01-05") as house,
        Node(house.runtime.graph, "owner") as node,
    ):
        await house.says("homeassistant/event/button/config", json.dumps(button))
        for day in range(DAYS):
            for hour, press in ((7 + 2 * (day % 4), "single"), (18 + day % 3, "double")):
                await house.run_until(house.now.replace(hour=hour, minute=4 * day))
                await house.says("button", json.dumps({"event_type": press}))
                await house.run_for(f"{10 + 5 * (day % 7)}s")
                await house.press("desk_lamp", "on" if press == "double" else "off")
            await house.run_until(house.now.replace(hour=0, minute=0) + timedelta(days=1))
        found = await Owner(node).proposals()
    assert {one.do: one.when for one in found.values()} == {
        "desk_lamp on": "Hall button press double",
        "desk_lamp off": "Hall button press single",
    }


async def test_a_routine_that_people_undo_is_proposed_for_removal() -> None:
    async with house_with_habits() as (house, owner):
        await owner.decide((await owner.proposals())["hall_lamp on"], accept=True)
        for seconds in (130, 310, 190, 370):  # after the same time, or whole minutes, a lamp does so by itself
            await house.becomes("hall_lamp", within="30h", on=True)
            await house.run_for(f"{seconds}s")
            await house.press("hall_lamp", "off")
        await house.run_for("1h")
        (removal,) = [one for one in (await owner.answer()).proposals if one.removes]
        assert removal.proof == "people undid 4 of its last 4 commands within ten minutes"
        assert (await owner.decide(removal, accept=True)).success
        assert await owner.routines() == {}
        assert not [one for one in (await owner.answer()).proposals if one.removes]
