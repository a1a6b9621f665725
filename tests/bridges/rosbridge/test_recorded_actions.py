"""The frames that roslibpy 2.1 and roslib 2.1 were recorded to exchange about actions, replayed at the door."""

import json
from pathlib import Path
from typing import Any

import anyio
import pytest
from tests.bridges.conftest import House, OpenHouse, Peer
from tests.graph.actions.fibonacci import Feedback, Fibonacci, Goal, Result
from tests.patience import PATIENCE

from homebot.graph.actions import ActionClient, ActionServer, GoalState, ServerGoal

LINES = [json.loads(line) for line in Path(__file__).with_name("action_frames.jsonl").read_text().splitlines()]
LIBRARIES = sorted({line["library"] for line in LINES})


def recorded(library: str, role: str) -> list[tuple[str, dict[str, Any]]]:
    """Return the direction and the frame of each line without a note."""
    found = [one for one in LINES if (one["library"], one["role"]) == (library, role) and "note" not in one]
    return [(one["dir"], one["frame"]) for one in found]


async def count(goal: ServerGoal[Any, Any, Any]) -> Result:
    """Execute a goal as the recorded server did: of order 50 until it is cancelled."""
    for last in range(3):
        goal.publish_feedback(Feedback(sequence=tuple(range(last + 1))))
    if goal.request.order == 50:
        while not goal.is_cancel_requested:  # noqa: ASYNC110 - as programs for ROS do
            await anyio.sleep(0.01)
        goal.canceled()
        return Result(sequence=(0,))
    goal.succeed()
    return Result(sequence=(0, 1, 1))


async def replay(peer: Peer, frames: list[tuple[str, dict[str, Any]]]) -> None:
    """Send what the client sent, and hold what it gets against what it got; reasons are texts of our own."""
    for direction, frame in frames:
        if direction == "from_client":
            await peer.connection.send(json.dumps(frame))
            continue
        got = await peer.receive()
        if frame.get("result") is False:
            assert isinstance(got["values"], str)
            got["values"] = frame["values"]
        assert got == frame


@pytest.mark.parametrize("library", LIBRARIES)
async def test_a_recorded_client_of_an_action_gets_what_it_got(house: House, library: str) -> None:
    async with house.node("counter") as node, house.peer() as peer:
        on_goal, on_cancel = (lambda goal: goal.order >= 0), (lambda _goal: True)
        ActionServer(node, Fibonacci, "/fib", count, on_goal=on_goal, on_cancel=on_cancel)
        await replay(peer, recorded(library, "client"))


async def test_a_recorded_server_of_an_action_is_asked_what_it_was_asked(open_house: OpenHouse) -> None:
    frames = recorded("roslib 2.1.0 (npm)", "server")
    goals, seen, ends = [], list[tuple[int, ...]](), list[tuple[GoalState, Result]]()
    async with open_house() as house, house.node("app") as app, house.peer() as peer:
        client = ActionClient(app, Fibonacci, "/fib")
        for direction, frame in frames:
            if frame["op"] == "send_action_goal":
                sent = Goal(**frame["args"])
                goals.append(await client.send_goal(sent, lambda feedback: seen.append(tuple(feedback.sequence))))
            if frame["op"] == "cancel_action_goal":
                await goals[-1].cancel()
            if frame["op"] == "unadvertise_action":
                ends = [await goal.result() for goal in goals]
            await replay(peer, [(direction, frame)])
            if direction == "from_client":
                await peer.settle()
    assert [state.name for state, _ in ends] == ["SUCCEEDED", "CANCELED", "ABORTED"]
    assert [tuple(result.sequence) for _, result in ends] == [(0, 1), (9,), ()]
    assert seen == [(0,), (1,), (0,), (1,), (2,), (3,)]


async def test_a_recorded_cancellation_of_all_goals_needs_no_id(house: House) -> None:
    (call,) = (one["frame"] for one in LINES if one["frame"]["op"] == "call_service")
    async with house.node("robot") as node, house.peer() as peer:
        ActionServer(node, Fibonacci, "/spin", count, on_cancel=lambda _goal: True)
        goal = await ActionClient(node, Fibonacci, "/spin").send_goal(Goal(order=50))
        await peer.connection.send(json.dumps(call))
        with anyio.fail_after(PATIENCE):
            assert (await goal.result())[0] is GoalState.CANCELED
