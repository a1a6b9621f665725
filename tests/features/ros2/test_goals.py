"""The link: actions of a house and of a robot."""

from collections.abc import Awaitable, Callable
from dataclasses import replace
from functools import partial
from typing import Any

import anyio
import pytest
from structlog.testing import capture_logs
from tests.features.ros2.bare_robot import Meeting, meeting
from tests.features.ros2.pair import appears, pair
from tests.patience import PATIENCE

from homebot.bridges.zenoh.attachment import Attachment
from homebot.bridges.zenoh.tokens import EntityToken
from homebot.devices.action_messages import HoldDevice, HoldDeviceFeedback, HoldDeviceGoal, HoldDeviceResult
from homebot.devices.command_messages import Setting
from homebot.devices.value import Value
from homebot.errors import GoalRejectedError
from homebot.graph import EntityKind, Graph, Node
from homebot.graph.actions import ActionClient, ActionServer, ClientGoal, GoalState, ServerGoal
from homebot.messages.action_msgs import CancelGoal, CancelGoalRequest, GoalInfo
from homebot.messages.builtin_interfaces import Time
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.messages.type_hash import type_hash
from homebot.messages.unique_identifier_msgs import UUID

Goal = ServerGoal[HoldDeviceGoal, HoldDeviceResult, HoldDeviceFeedback]
ALL_GOALS = CancelGoalRequest(goal_info=GoalInfo(goal_id=UUID(uuid=bytes(16)), stamp=Time(sec=0, nanosec=0)))
LAMP = HoldDeviceGoal(device="lamp", setting=Setting(capability="on", value=Value.of(True)), issuer="client:owner")


class Holder:
    """An action server that holds until it is cancelled or released."""

    def __init__(self, node: Node, name: str) -> None:
        self.goals: list[HoldDeviceGoal] = []
        self.released, self.began, self.ended = anyio.Event(), anyio.Event(), anyio.Event()
        self.server = ActionServer(node, HoldDevice, name, self._hold)

    async def _hold(self, goal: Goal) -> HoldDeviceResult:
        self.goals.append(goal.request)
        self.began.set()
        try:
            goal.publish_feedback(HoldDeviceFeedback(phase="held", seconds_left=1, message=goal.request.device))
            await self.released.wait()
        finally:
            self.ended.set()
        goal.succeed()
        return HoldDeviceResult(success=True, message="done")


async def all_parts(graph: Graph, action: str) -> None:
    """Wait until *graph* has all of *action*; it comes in parts."""
    for part in ("send_goal", "cancel_goal", "get_result", "feedback", "status"):
        await appears(graph, f"{action}/_action/{part}")


async def sent(
    node: Node, action: str, on_feedback: Callable[[HoldDeviceFeedback], Awaitable[None] | None] | None = None
) -> ClientGoal[HoldDeviceResult, HoldDeviceFeedback]:
    with anyio.fail_after(PATIENCE):
        await all_parts(node.graph, action)
        return await ActionClient(node, HoldDevice, action).send_goal(LAMP, on_feedback)


async def test_a_robot_drives_an_action_of_the_house_as_the_client_that_its_token_names() -> None:
    async with pair("read", "act: harmless") as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        holder, heard = Holder(app, "/house/hold"), anyio.Event()
        goal = await sent(nav, "/house/hold", lambda _: heard.set())
        with anyio.fail_after(PATIENCE):
            await heard.wait()
            holder.released.set()
            assert await goal.result() == (GoalState.SUCCEEDED, HoldDeviceResult(success=True, message="done"))
    assert [(one.device, one.issuer, one.scope) for one in holder.goals] == [
        ("lamp", "client:rosie", ("act: harmless",))
    ]


async def test_an_action_that_waits_for_its_first_use_is_exported() -> None:
    async with pair() as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        app.offer_action(HoldDevice.ros_type, "/house/hold", partial(Holder, app, "/house/hold"))
        await sent(nav, "/house/hold")


async def test_a_goal_that_a_robot_cancels_ends_so() -> None:
    async with pair() as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        holder = Holder(app, "/house/hold")
        goal = await sent(nav, "/house/hold")
        with anyio.fail_after(PATIENCE):
            await holder.began.wait()
            assert (await goal.cancel()).goals_canceling[0].goal_id == goal.goal_id
            assert (await goal.result())[0] is GoalState.CANCELED


async def test_a_robot_cancels_all_its_goals_and_none_of_others() -> None:
    async with pair() as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
        holder = Holder(app, "/house/hold")
        theirs, own = await sent(nav, "/house/hold"), await sent(app, "/house/hold")
        with anyio.fail_after(PATIENCE):
            await appears(both.robot, "/house/hold/_action/cancel_goal")
            cancel = nav.create_client(CancelGoal, "/house/hold/_action/cancel_goal")
            answer = await cancel.call(ALL_GOALS, PATIENCE)
            assert [one.goal_id for one in answer.goals_canceling] == [theirs.goal_id]
            by_id = ALL_GOALS.model_copy(
                update={"goal_info": GoalInfo(goal_id=own.goal_id, stamp=Time.from_seconds(0))}
            )
            assert (await cancel.call(by_id, PATIENCE)).return_code == 2
            assert (await theirs.result())[0] is GoalState.CANCELED
            holder.released.set()
            assert (await own.result())[0] is GoalState.SUCCEEDED


async def test_a_goal_without_the_right_is_rejected_and_the_log_says_why() -> None:
    with capture_logs() as lines:
        async with pair("read") as both, Node(both.house, "app") as app, Node(both.robot, "nav") as nav:
            holder = Holder(app, "/house/hold")
            with pytest.raises(GoalRejectedError):
                await sent(nav, "/house/hold")
    assert holder.goals == []
    refused = [line["problem"] for line in lines if line["event"] == "ros2.call_refused"]
    assert "the right act is missing; the token rosie has: read." in refused[0]


async def test_the_goals_of_a_robot_end_when_it_leaves() -> None:
    async with Node(Graph(), "app") as app:
        holder = Holder(app, "/house/hold")
        async with pair(house=app.graph) as both, Node(both.robot, "nav") as nav:
            await sent(nav, "/house/hold")
            with anyio.fail_after(PATIENCE):
                await holder.began.wait()
                both.leave()
                await holder.ended.wait()
            assert [one.state for one in holder.server.goals] == []


async def test_an_action_of_a_robot_is_one_of_the_house() -> None:
    async with (
        pair("read", "robot: rosie") as both,
        Node(both.house, "app") as app,
        Node(both.robot, "nav") as nav,
    ):
        holder, heard = Holder(nav, "/rosie/hold"), anyio.Event()
        goal = await sent(app, "/rosie/hold", lambda _: heard.set())
        (action,) = both.house.actions()
        assert (action.name, action.ros_type, action.servers) == (
            "/rosie/hold",
            "homebot/action/HoldDevice",
            ("/ros2",),
        )
        with anyio.fail_after(PATIENCE):
            await heard.wait()
            holder.released.set()
            assert await goal.result() == (GoalState.SUCCEEDED, HoldDeviceResult(success=True, message="done"))
    assert both.house.actions() == ()


async def test_an_action_of_a_robot_is_cancelled_from_the_house() -> None:
    async with (
        pair("read", "robot: rosie") as both,
        Node(both.house, "app") as app,
        Node(both.robot, "nav") as nav,
    ):
        holder = Holder(nav, "/rosie/hold")
        goal = await sent(app, "/rosie/hold")
        with anyio.fail_after(PATIENCE):
            await holder.began.wait()
            await goal.cancel()
            assert (await goal.result())[0] is GoalState.CANCELED


async def result_of_unknown_goal(both: Meeting, client: EntityToken) -> Any:
    """Return the response to a call of *client*, whose token the house may not have."""
    request = message_to_cdr(HoldDevice.GetResult.Request(goal_id=UUID(uuid=bytes(16))))
    attachment = Attachment(1, 0, client.gid).to_bytes()
    with anyio.fail_after(PATIENCE):
        while (answer := await both.robot.ask(client.key, request, attachment, PATIENCE)) is None:
            pass  # the robot does not know the action yet
    assert isinstance(answer, bytes)
    return message_from_cdr(HoldDevice.GetResult.Response, answer)


async def declared(both: Meeting, client: EntityToken) -> None:
    both.declare(client)


@pytest.mark.parametrize("comes", [True, False])
async def test_a_client_whose_token_comes_after_its_call_is_answered_and_one_without_is_refused(*, comes: bool) -> None:
    async with meeting() as both:
        Holder(both.app, "/house/hold")
        service = HoldDevice.GetResult
        client = both.token(EntityKind.CLIENT, "/house/hold/_action/get_result", service.ros_type, type_hash(service))
        both.declare(both.token(EntityKind.NODE, "/rosie/nav"))
        await appears(both.app.graph, "/rosie/nav")
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(both.robot.run)
            if comes:
                tasks.start_soon(declared, both, client)  # its turn is after the call
            assert (await result_of_unknown_goal(both, client)).status == GoalState.UNKNOWN
            tasks.cancel_scope.cancel()
        refused = {one.name: one.count for one in (await both.health()).counts}["call_refused"]
        assert refused == (0 if comes else 1)


async def test_a_goal_whose_id_comes_again_remains_its_sender_s_and_ends_with_its_process() -> None:
    """Another process with a node of the same name does not keep it, nor may it cancel it."""
    async with meeting() as both:
        holder = Holder(both.app, "/house/hold")
        service = HoldDevice.SendGoal
        name = "/house/hold/_action/send_goal"
        client = both.token(EntityKind.CLIENT, name, service.ros_type, type_hash(service))
        both.declare(both.token(EntityKind.NODE, "/rosie/nav"))
        both.declare(client)
        other = replace(both.token(EntityKind.NODE, "/rosie/nav"), session="0123456789abcdef")
        kept = both.robot.declare_token(other.text)
        await appears(both.app.graph, "/rosie/nav")
        request = message_to_cdr(service.Request(goal_id=UUID(uuid=bytes(range(16))), goal=LAMP))
        answers: list[bool] = []
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(both.robot.run)
            with anyio.fail_after(PATIENCE):
                while len(answers) < 3:
                    attachment = Attachment(1, 0, client.gid).to_bytes()
                    answer = await both.robot.ask(client.key, request, attachment, PATIENCE)
                    if isinstance(answer, bytes):
                        answers.append(message_from_cdr(service.Response, answer).accepted)
                assert answers == [True, False, False]
                await holder.began.wait()
                both.take_back()
                await holder.ended.wait()
            tasks.cancel_scope.cancel()
        kept.undeclare()
