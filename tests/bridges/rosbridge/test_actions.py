"""Actions at the door, in both directions: the frames that roslib and roslibpy exchange."""

import asyncio
from typing import Any

import anyio
import pytest
from tests.bridges.conftest import House
from tests.bridges.fibonacci import server
from tests.graph.actions.fibonacci import Fibonacci, Goal, Result
from tests.patience import PATIENCE

from homebot.graph.actions import ActionClient, ActionServer, GoalState

GOAL = {"action": "/fib", "action_type": "example_interfaces/action/Fibonacci", "feedback": True}


async def the_end(server: ActionServer[Any, Any, Any]) -> None:
    """Return when the server has no goal any more."""
    with anyio.fail_after(PATIENCE):
        for goal in server.goals:
            await asyncio.shield(goal.outcome)
    assert server.goals == ()


async def test_a_goal_that_fails_has_a_result(house: House) -> None:
    async with server(house.graph), house.peer() as peer:
        await peer.send("send_action_goal", id="g:1", args={"order": 7}, **GOAL)
        end = {"op": "action_result", "action": "/fib", "id": "g:1"}
        assert await peer.receive() == {**end, "values": {"sequence": [7]}, "status": 6, "result": True}


async def test_a_cancelled_goal_ends_once_and_only_that_of_its_own_client(house: House) -> None:
    """Both clients chose the same id, as roslibpy does; one goal is cancelled before it can be accepted."""
    async with server(house.graph) as fib, house.peer() as first, house.peer() as second:
        for peer in (first, second):
            await peer.tell("send_action_goal", id="g", args={"order": 50}, **GOAL)
        await first.send("cancel_action_goal", id="g", action="/fib")
        ended = await first.receive()
        assert (ended["op"], ended["id"], ended["status"], ended["result"]) == ("action_result", "g", 5, True)
        await second.settle()
        assert len(fib.goals) == 1
        await first.send("cancel_action_goal", id="g", action="/fib")
        assert (await first.receive())["op"] == "status"


async def test_a_goal_that_is_sent_again_under_its_id_goes_on(house: House) -> None:
    """A result with the id of both would end it for its client."""
    async with server(house.graph) as fib, house.peer() as peer:
        await peer.tell("send_action_goal", id="g", args={"order": 50}, **GOAL)
        await peer.send("send_action_goal", id="g", args={"order": 50}, **GOAL)
        refused = await peer.receive()
        assert (refused["op"], refused["id"], refused["level"]) == ("status", "g", "error")
        assert "a goal with the id 'g' is under way already" in refused["msg"]
        assert len(fib.goals) == 1


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"action": "/nobody"}, "action /nobody has no server now; /rosapi/action_servers lists all"),
        ({"action": "/fibb"}, "action /fibb has no server now; did you mean /fib?"),
        ({"action_type": "nav2_msgs/action/Spin"}, "is a example_interfaces/action/Fibonacci, not a nav2_msgs"),
        ({"args": {"order": "three"}}, "field 'order'"),
        ({"args": 3}, "field 'args': has to be an object, or a list of the fields in order, got 3"),
    ],
)
async def test_a_goal_that_cannot_be_sent_has_a_result_too(
    house: House, change: dict[str, object], problem: str
) -> None:
    async with server(house.graph), house.peer() as peer:
        await peer.send("send_action_goal", **{"id": "g", "args": {"order": 3}, **GOAL, **change})
        refused = await peer.receive()
        assert (refused["op"], refused["id"], refused["status"], refused["result"]) == ("action_result", "g", 0, False)
        assert problem in refused["values"]


async def test_the_goals_of_a_client_end_with_its_connection(house: House) -> None:
    async with server(house.graph) as fib:
        async with house.peer() as peer:
            await peer.tell("send_action_goal", id="g", args={"order": 50}, **GOAL)
            assert len(fib.goals) == 1
        await the_end(fib)
        assert house.entities() == set()


async def test_the_goals_of_a_client_that_vanishes_end(house: House) -> None:
    """It neither closes its connection nor answers; one without goals may be silent for longer."""
    async with server(house.graph) as fib, house.peer() as idle, house.peer() as peer:
        await idle.settle()
        await peer.tell("send_action_goal", id="g", args={"order": 50}, **GOAL)
        began = anyio.current_time()
        for one in (idle, peer):
            one.connection.transport.pause_reading()
        await the_end(fib)
        assert 0.4 < anyio.current_time() - began < 5
        assert house.server.client_count == 1
        peer.connection.transport.abort()
        idle.connection.transport.resume_reading()
        await idle.settle()


async def test_a_second_result_as_of_a_client_that_advertised_twice_is_ignored(house: House) -> None:
    async with house.node("app") as app, house.peer() as robot:
        client = ActionClient(app, Fibonacci, "/fib")
        await robot.tell("advertise_action", action="/fib", type="example_interfaces/action/Fibonacci")
        performed = asyncio.create_task(client.perform(Goal(order=2)))
        asked = await robot.receive()
        assert asked == {"op": "send_action_goal", "id": "action_goal:/fib:1", "args": {"order": 2}, **GOAL}
        about = {"id": asked["id"], "action": "/fib"}
        for _ in range(2):
            await robot.tell("action_result", values={"sequence": [0, 1]}, status=4, result=True, **about)
        assert await performed == Result(sequence=(0, 1))


async def test_a_goal_that_is_cancelled_at_once_reaches_its_client_before_the_cancellation(house: House) -> None:
    async with house.node("app") as app, house.peer() as robot:
        client = ActionClient(app, Fibonacci, "/fib")
        await robot.tell("advertise_action", action="/fib", type="example_interfaces/Fibonacci")
        (await client.send_goal(Goal(order=2))).request_cancel()
        asked = await robot.receive()
        assert (asked["op"], asked["action_type"]) == ("send_action_goal", "example_interfaces/Fibonacci")  # as it said
        assert (await robot.receive())["op"] == "cancel_action_goal"


@pytest.mark.parametrize("status", [4, 5, 6])
async def test_a_goal_that_is_cancelled_ends_as_its_server_says(house: House, status: int) -> None:
    """A robot that is in its dock when the cancellation arrives has succeeded."""
    async with house.peer() as robot, house.peer() as user:
        await robot.tell("advertise_action", action="/fib", type="example_interfaces/action/Fibonacci")
        await user.send("send_action_goal", id="g", args={"order": 5}, **GOAL)
        asked = await robot.receive()
        await user.send("cancel_action_goal", id="g", action="/fib")
        assert (await robot.receive())["op"] == "cancel_action_goal"
        end = {"values": {"sequence": [0]}, "status": status, "result": True}
        await robot.send("action_result", id=asked["id"], action="/fib", **end)
        assert await user.receive() == {"op": "action_result", "id": "g", "action": "/fib", **end}


@pytest.mark.parametrize(("is_success", "status"), [(True, 4), (False, 6)])
async def test_a_goal_without_a_status_ends_as_its_result_says(house: House, is_success: object, status: int) -> None:
    """The first ``Action`` of roslib states none."""
    async with house.peer() as robot, house.peer() as user:
        await robot.tell("advertise_action", action="/fib", type="example_interfaces/action/Fibonacci")
        await user.send("send_action_goal", id="g", args={"order": 5}, **GOAL)
        asked = await robot.receive()
        await robot.send("action_result", id=asked["id"], action="/fib", values={"sequence": [0]}, result=is_success)
        assert (await user.receive())["status"] == status


async def test_the_goals_of_a_server_that_leaves_are_aborted(house: House) -> None:
    async with house.node("app") as app:
        client = ActionClient(app, Fibonacci, "/fib")
        async with house.peer() as robot:
            await robot.tell("advertise_action", action="/fib", type="example_interfaces/action/Fibonacci")
            goal = await client.send_goal(Goal(order=2))
            await robot.receive()
        with anyio.fail_after(PATIENCE):
            assert (await goal.result())[0] is GoalState.ABORTED


async def test_a_list_fills_the_fields_of_a_goal_and_what_it_and_its_end_lack_is_zero_or_empty(house: House) -> None:
    async with house.peer() as robot, house.peer() as user:
        await robot.tell("advertise_action", action="/fib", type="example_interfaces/action/Fibonacci")
        await user.send("send_action_goal", id="first", args=[5], **GOAL)
        asked = await robot.receive()
        assert asked["args"] == {"order": 5}
        await robot.send("action_result", id=asked["id"], action="/fib", values=[[5]], status=4, result=True)
        assert (await user.receive())["values"] == {"sequence": [5]}
        await user.send("send_action_goal", id="g", args={}, **GOAL)
        asked = await robot.receive()
        assert asked["args"] == {"order": 0}
        await robot.send("action_result", id=asked["id"], action="/fib", values={}, status=4, result=True)
        ended = await user.receive()
        assert (ended["id"], ended["status"], ended["values"]) == ("g", 4, {"sequence": []})
