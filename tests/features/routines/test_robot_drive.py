"""Routines that send the robot of a simulated house."""

from collections.abc import AsyncIterator, Sequence
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.config import parse_config
from homebot.devices.app_messages import (
    ChangeRoutine,
    ChangeRoutineRequest,
    ListRoutines,
    RoutineChange,
    RoutinesRequest,
)
from homebot.devices.names import CHANGE_ROUTINE, LIST_ROUTINES, WHERE_IS_ROBOT
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.graph import Node
from homebot.house import thesis_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.words.steps import SendRobot, read_step

pytestmark = [pytest.mark.virtual_time]


@asynccontextmanager
async def house(*steps: object, mode: str = "single", is_dry_run: bool = False) -> AsyncIterator[Node]:
    """Run the small house with a robot and a routine of *steps*; it drives 8.5 m from room 405 to room 165."""
    routine = {"name": "Round", "when": ["23:59"], "do": steps, "mode": mode}
    config = {"home": {"name": "home425"}, "gateways": {"mqtt": {"root": "home425"}}, "routines": [routine]}
    async with MemoryBroker() as broker:
        services = (HostedBroker.in_memory(broker),)
        runtime = Runtime(
            parse_config(config, "test"),
            house=thesis_world(),
            robot="robot",
            with_door=False,
            services=services,
            is_dry_run=is_dry_run,
        )
        async with runtime, Node(runtime.graph, "tester") as node:
            await anyio.sleep(2)  # the robot boots
            yield node


async def change(node: Node, change: RoutineChange) -> None:
    await node.create_client(ChangeRoutine, CHANGE_ROUTINE).call(ChangeRoutineRequest(name="Round", change=change))


async def room_of(node: Node) -> str:
    found = await node.create_client(WhereIsRobot, WHERE_IS_ROBOT).call(WhereIsRobotRequest())
    return found.pose[0].room


async def notes(node: Node) -> Sequence[str]:
    answer = await node.create_client(ListRoutines, LIST_ROUTINES).call(RoutinesRequest())
    return [one.text for one in answer.routines[0].notes]


def test_a_drive_is_written_in_words() -> None:
    assert read_step("Rosie go to the living room") == SendRobot("Rosie go to the living room", "rosie", "living room")
    dock = read_step("robot goes to dock")
    assert isinstance(dock, SendRobot)
    assert dock.is_to_dock


async def test_the_robot_drives_to_a_room_and_back_into_its_dock() -> None:
    async with house("robot go to room 165", "wait 1m", "robot go to dock") as node:
        assert await room_of(node) == "Room 405"
        await change(node, "run")
        await anyio.sleep(60)
        assert await room_of(node) == "Room 165"
        await anyio.sleep(120)
        assert await room_of(node) == "Room 405"
        assert await notes(node) == ["ran", "done: 'robot go to room 165'", "done: 'robot go to dock'"]


async def test_a_dry_run_sends_no_robot() -> None:
    async with house("robot go to room 165", is_dry_run=True) as node:
        await change(node, "run")
        await anyio.sleep(60)
        assert await room_of(node) == "Room 405"
        assert await notes(node) == ["ran", "done: 'robot go to room 165 (only recorded)'"]


async def test_it_stops_when_the_routine_is_switched_off() -> None:
    async with house("robot go to room 165") as node:
        await change(node, "run")
        await anyio.sleep(2)
        await change(node, "disable")
        await anyio.sleep(60)
        assert await room_of(node) == "Room 405"


async def test_a_second_start_sends_it_anew() -> None:
    async with house("robot go to room 165", mode="restart") as node:
        await change(node, "run")
        await anyio.sleep(2)
        await change(node, "run")
        await anyio.sleep(60)
        assert await room_of(node) == "Room 165"
        assert await notes(node) == ["ran", "ran", "done: 'robot go to room 165'"]


@pytest.mark.parametrize(
    ("step", "problem"),
    [
        ("rosie go to room 165", "there is no robot 'rosie'; robots are robot"),
        ("robot go to room 166", "there is no room 'room 166'; did you mean Room 165 or Room 405?"),
    ],
)
async def test_a_drive_that_is_not_possible_says_why(step: str, problem: str) -> None:
    async with house(step) as node:
        await change(node, "run")
        await anyio.sleep(1)
        assert (await notes(node))[-1] == f"{step!r} failed: {problem}"
