"""Actions from end to end: states, results, cancellation, preemption and ends, as ROS 2 has them."""

import asyncio
from collections.abc import Awaitable, Callable

import anyio
import pytest
from tests.graph.actions.fibonacci import Client, Feedback, Fibonacci, Goal, Result, Served

from homebot.errors import (
    DuplicateNameError,
    GoalAbortedError,
    GoalCanceledError,
    GoalRejectedError,
    ServiceGoneError,
    ServiceUnavailableError,
    UsageError,
)
from homebot.graph import Graph, Node, qos_profile_latched
from homebot.graph.actions import ActionServer, GoalState, Preemption
from homebot.messages.action_msgs import CancelGoal, CancelGoalRequest, CancelGoalResponse, GoalInfo, GoalStatusArray
from homebot.messages.builtin_interfaces import Time
from homebot.messages.unique_identifier_msgs import UUID

pytestmark = pytest.mark.virtual_time

EMPTY = Result(sequence=())
NO_TIME = Time(sec=0, nanosec=0)
NO_ID = UUID(uuid=bytes(16))


async def compute(goal: Served) -> Result:
    """Compute one number in a second, with feedback."""
    numbers = [0, 1]
    while len(numbers) < goal.request.order:
        await anyio.sleep(1.0)
        numbers.append(numbers[-1] + numbers[-2])
        goal.publish_feedback(Feedback(sequence=tuple(numbers)))
    goal.succeed()
    return Result(sequence=tuple(numbers))


async def wait_long(goal: Served) -> Result:
    await anyio.sleep(100.0)
    goal.succeed()
    return EMPTY


def client_of(node: Node) -> Client:
    return Client(node, Fibonacci, "fib")


def states_on(node: Node) -> list[list[int]]:
    seen: list[list[int]] = []

    def on_states(message: GoalStatusArray) -> None:
        seen.append([one.status for one in message.status_list])

    node.create_subscription(GoalStatusArray, "/fib/_action/status", on_states, qos_profile_latched)
    return seen


async def cancel(node: Node, goal_id: UUID = NO_ID, stamp: Time = NO_TIME) -> CancelGoalResponse:
    client = node.create_client(CancelGoal, "/fib/_action/cancel_goal")
    response = await client.call(CancelGoalRequest(goal_info=GoalInfo(goal_id=goal_id, stamp=stamp)))
    client.close()
    return response


@pytest.fixture
async def other(run: Callable[[str], Awaitable[Node]]) -> Node:
    return await run("other")


async def test_a_goal_is_performed_with_feedback(node: Node, other: Node) -> None:
    ActionServer(node, Fibonacci, "fib", compute)
    feedback: list[int] = []
    result = await client_of(other).perform(Goal(order=5), lambda message: feedback.append(len(message.sequence)))
    assert result == Result(sequence=(0, 1, 1, 2, 3))
    assert feedback == [3, 4, 5]


async def test_every_change_of_state_is_published_and_the_last_one_latched(node: Node, other: Node) -> None:
    ActionServer(node, Fibonacci, "fib", compute)
    seen = states_on(other)
    goal = await client_of(other).send_goal(Goal(order=3))
    known = [goal.status]
    await anyio.sleep(0.5)
    assert [*known, goal.status] == [GoalState.ACCEPTED, GoalState.EXECUTING]
    assert await goal.result() == (GoalState.SUCCEEDED, Result(sequence=(0, 1, 1)))
    await anyio.sleep(0.1)
    late = states_on(other)
    await anyio.sleep(0.1)
    assert [seen[-1], late] == [[4], [[4]]]
    await anyio.sleep(10.0)
    assert seen[-1] == []


async def test_cancelling_perform_cancels_the_goal(node: Node, other: Node) -> None:
    ended = []

    async def execute(goal: Served) -> Result:
        try:
            return await wait_long(goal)
        finally:
            ended.append(goal.is_cancel_requested)

    server = ActionServer(node, Fibonacci, "fib", execute)
    with anyio.move_on_after(3.0):
        await client_of(other).perform(Goal(order=1))
    await anyio.sleep(0.01)
    assert ended == [True]
    assert not server.goals


async def test_cancelling_perform_before_the_acceptance_cancels_the_goal(node: Node, other: Node) -> None:
    """A server elsewhere may take its time to accept a goal."""
    asked: list[CancelGoalRequest] = []

    async def accept_late(_request: object) -> object:
        await anyio.sleep(2.0)
        return Fibonacci.SendGoal.Response(accepted=True, stamp=NO_TIME)

    async def cancel_late(request: CancelGoalRequest) -> CancelGoalResponse:
        await anyio.sleep(0.1)
        asked.append(request)
        return CancelGoalResponse(return_code=0, goals_canceling=())

    node.create_service(Fibonacci.SendGoal, "/fib/_action/send_goal", accept_late)
    node.create_service(CancelGoal, "/fib/_action/cancel_goal", cancel_late)
    with anyio.move_on_after(1.0):
        await client_of(other).perform(Goal(order=1))
    await anyio.sleep(1.0)
    assert len(asked) == 1


async def test_a_cancelled_goal_is_canceled_for_other_clients(node: Node, other: Node) -> None:
    ActionServer(node, Fibonacci, "fib", wait_long)
    goal = await client_of(other).send_goal(Goal(order=1))
    await anyio.sleep(1.0)
    response = await goal.cancel()
    assert (response.return_code, [info.goal_id for info in response.goals_canceling]) == (0, [goal.goal_id])
    assert await goal.result() == (GoalState.CANCELED, EMPTY)
    performed = asyncio.create_task(client_of(other).perform(Goal(order=1)))
    await anyio.sleep(1.0)
    await cancel(node)
    with pytest.raises(GoalCanceledError, match="action /fib cancelled the goal"):
        await performed


async def test_a_failed_execution_aborts_with_an_empty_result(node: Node, other: Node, graph: Graph) -> None:
    async def fail(_goal: Served) -> Result:
        await anyio.sleep(0.1)
        raise ValueError("no power")

    ActionServer(node, Fibonacci, "fib", fail)
    with pytest.raises(GoalAbortedError) as caught:
        await client_of(other).perform(Goal(order=1))
    assert caught.value.result == EMPTY
    assert [(one.callback, one.last) for one in graph.failures] == [("execution of /fib", "ValueError: no power")]


@pytest.mark.parametrize("returned", [Result(sequence=(7,)), None])
async def test_an_execution_without_a_terminal_state_is_aborted(
    node: Node, other: Node, returned: Result | None
) -> None:
    async def forget(_goal: Served) -> Result | None:
        return returned

    ActionServer(node, Fibonacci, "fib", forget)
    goal = await client_of(other).send_goal(Goal(order=1))
    assert await goal.result() == (GoalState.ABORTED, returned or EMPTY)


async def test_goals_are_rejected_by_choice_and_as_duplicates(node: Node, other: Node) -> None:
    ActionServer(node, Fibonacci, "fib", wait_long, on_goal=lambda goal: goal.order > 0)
    client = client_of(other)
    with pytest.raises(GoalRejectedError):
        await client.send_goal(Goal(order=0))
    first = await client.send_goal(Goal(order=1))
    with pytest.raises(GoalRejectedError):
        await client_of(node).send_goal(Goal(order=1), goal_id=first.goal_id)


async def test_without_a_server_a_goal_is_refused_at_once(other: Node) -> None:
    with pytest.raises(ServiceUnavailableError):
        await client_of(other).perform(Goal(order=1))


async def test_states_follow_only_as_in_ros(node: Node, other: Node) -> None:
    errors = []

    async def execute(goal: Served) -> Result:
        try:
            goal.canceled()
        except UsageError as exc:
            errors.append(str(exc))
        goal.succeed(Result(sequence=(1,)))
        try:
            goal.abort()
        except UsageError as exc:
            errors.append(str(exc))
        return EMPTY

    ActionServer(node, Fibonacci, "fib", execute)
    assert await client_of(other).perform(Goal(order=1)) == Result(sequence=(1,))
    assert errors == [
        "a goal that is EXECUTING cannot become CANCELED",
        "a goal that is SUCCEEDED cannot become ABORTED",
    ]


async def test_cancel_requests_select_goals_by_id_and_time(node: Node, other: Node) -> None:
    """One that names a time covers all goals accepted until then, and the named one."""

    async def stop_when_asked(goal: Served) -> Result:
        while not goal.is_cancel_requested:  # noqa: ASYNC110 - as programs for ROS do
            await anyio.sleep(1.0)
        await anyio.sleep(5.0)
        goal.canceled()
        return EMPTY

    ActionServer(node, Fibonacci, "fib", stop_when_asked, on_cancel=lambda goal: goal.request.order != 13)
    client = client_of(other)
    goals = []
    for order in (1, 13, 2, 3, 4, 5):
        goals.append(await client.send_goal(Goal(order=order)))
        await anyio.sleep(1.0)
    first, stubborn, second, third, fourth, fifth = goals
    assert (await cancel(node, UUID(uuid=bytes(15) + b"1"))).return_code == CancelGoalResponse.ERROR_UNKNOWN_GOAL_ID
    assert (await cancel(node, stubborn.goal_id)).return_code == CancelGoalResponse.ERROR_REJECTED
    response = await cancel(node, fifth.goal_id, second.stamp)
    assert [info.goal_id for info in response.goals_canceling] == [one.goal_id for one in (first, second, fifth)]
    assert (await cancel(node, first.goal_id)).return_code == CancelGoalResponse.ERROR_GOAL_TERMINATED
    response = await cancel(node)
    assert (response.return_code, len(response.goals_canceling)) == (CancelGoalResponse.ERROR_NONE, 2)
    for goal in (first, second, third, fourth, fifth):
        assert (await goal.result())[0] is GoalState.CANCELED
    assert (await cancel(node, first.goal_id)).return_code == CancelGoalResponse.ERROR_GOAL_TERMINATED


async def test_results_are_kept_for_their_time(node: Node, other: Node) -> None:
    ActionServer(node, Fibonacci, "fib", compute, result_timeout=10.0)
    client = client_of(other)
    asked = await client.send_goal(Goal(order=3))
    other_client = other.create_client(Fibonacci.GetResult, "/fib/_action/get_result")

    async def status_of(goal_id: UUID) -> int:
        response = await other_client.call(Fibonacci.GetResult.Request(goal_id=goal_id))
        return int(response.status)

    await asked.result()
    await anyio.sleep(9.0)
    assert await status_of(asked.goal_id) == GoalState.SUCCEEDED
    await anyio.sleep(2.0)
    assert await status_of(asked.goal_id) == GoalState.UNKNOWN
    assert (await asked.result())[0] is GoalState.SUCCEEDED


class Line:
    """Executions in order of their begin, and how many at once."""

    def __init__(self) -> None:
        self.begun: list[int] = []
        self.running = 0
        self.most = 0

    async def execute(self, goal: Served) -> Result:
        self.begun.append(goal.request.order)
        self.running += 1
        self.most = max(self.most, self.running)
        try:
            await anyio.sleep(10.0)
        finally:
            with anyio.CancelScope(shield=True):
                await anyio.sleep(1.0)
            self.running -= 1
        goal.succeed()
        return EMPTY


async def test_preemption_rejects_the_new_goal(node: Node, other: Node) -> None:
    ActionServer(node, Fibonacci, "fib", wait_long, preemption=Preemption.REJECT)
    await client_of(other).send_goal(Goal(order=1))
    with pytest.raises(GoalRejectedError):
        await client_of(other).send_goal(Goal(order=2))


async def test_preemption_aborts_the_old_goal_and_waits_for_its_end(node: Node, other: Node) -> None:
    line = Line()
    ActionServer(node, Fibonacci, "fib", line.execute, preemption=Preemption.ABORT)
    client = client_of(other)
    first = await client.send_goal(Goal(order=1))
    await anyio.sleep(5.0)
    second = await client.send_goal(Goal(order=2))
    third = await client.send_goal(Goal(order=3))
    assert [(await goal.result())[0].name for goal in (first, second, third)] == ["ABORTED", "ABORTED", "SUCCEEDED"]
    assert (line.begun, line.most) == ([1, 3], 1)


async def test_a_server_that_closes_while_a_goal_is_being_preempted_answers_at_once(node: Node, other: Node) -> None:
    server = ActionServer(node, Fibonacci, "fib", Line().execute, preemption=Preemption.ABORT)
    client = client_of(other)
    first = await client.send_goal(Goal(order=1))
    await anyio.sleep(0.5)
    result = asyncio.create_task(first.result())
    await client.send_goal(Goal(order=2))
    await anyio.sleep(0.1)
    server.close()
    with anyio.fail_after(0.1):
        assert await result == (GoalState.ABORTED, EMPTY)


async def test_preemption_queues_goals_and_a_waiting_one_is_cancelled_at_once(node: Node, other: Node) -> None:
    line = Line()
    ActionServer(node, Fibonacci, "fib", line.execute, preemption=Preemption.QUEUE, on_cancel=lambda _goal: False)
    client = client_of(other)
    goals = [await client.send_goal(Goal(order=order)) for order in (1, 2, 3)]
    await anyio.sleep(1.0)
    assert (await goals[1].cancel()).return_code == 0
    with anyio.fail_after(0.1):
        assert (await goals[1].result())[0] is GoalState.CANCELED
    assert [(await goal.result())[0].name for goal in goals] == ["SUCCEEDED", "CANCELED", "SUCCEEDED"]
    assert (line.begun, line.most) == ([1, 3], 1)


async def test_goals_run_at_once_without_preemption(node: Node, other: Node) -> None:
    line = Line()
    ActionServer(node, Fibonacci, "fib", line.execute)
    client = client_of(other)
    await asyncio.gather(*(client.perform(Goal(order=order)) for order in (1, 2, 3)))
    assert line.most == 3


async def test_a_server_that_closes_answers_all(node: Node, other: Node, graph: Graph) -> None:
    server = ActionServer(node, Fibonacci, "fib", wait_long)
    seen = states_on(other)
    goal = await client_of(other).send_goal(Goal(order=1))
    results = [asyncio.create_task(goal.result()) for _ in range(2)]
    await anyio.sleep(1.0)
    server.close()
    assert await asyncio.gather(*results) == [(GoalState.ABORTED, EMPTY)] * 2
    assert seen[-1] == [6]
    again = ActionServer(node, Fibonacci, "fib", compute)
    with pytest.raises(DuplicateNameError):
        ActionServer(other, Fibonacci, "fib", compute)
    again.close()
    assert [(action.name, action.servers) for action in graph.actions()] == [("/fib", ())]


@pytest.mark.parametrize("end", ["leave", "close"])
async def test_the_end_of_the_serving_node_answers_all(graph: Graph, other: Node, end: str) -> None:
    serving = Node(graph, "serving")
    async with serving:
        ActionServer(serving, Fibonacci, "fib", wait_long)
        goal = await client_of(other).send_goal(Goal(order=1))
        result = asyncio.create_task(goal.result())
        await anyio.sleep(1.0)
        if end == "close":
            serving.close()
    with anyio.fail_after(1.0):
        assert (await result)[0] is GoalState.ABORTED
    with pytest.raises((ServiceGoneError, ServiceUnavailableError)):
        await client_of(other).perform(Goal(order=1))


@pytest.mark.parametrize("end", ["client", "leave", "close"])
async def test_goals_end_with_their_client(node: Node, graph: Graph, end: str) -> None:
    server = ActionServer(node, Fibonacci, "fib", wait_long)
    sending = Node(graph, "sending")
    async with sending:
        client = client_of(sending)
        await client.send_goal(Goal(order=1))
        await anyio.sleep(1.0)
        assert len(server.goals) == 1
        if end == "client":
            client.close()
            await anyio.sleep(0.01)
            assert not server.goals
        if end == "close":
            sending.close()
    await anyio.sleep(0.01)
    assert not server.goals


async def test_goals_at_once_are_bounded_and_refusals_counted(node: Node, other: Node, graph: Graph) -> None:
    ActionServer(node, Fibonacci, "fib", wait_long)
    client = client_of(other)
    for _ in range(256):
        await client.send_goal(Goal(order=1))
    with pytest.raises(GoalRejectedError):
        await client.send_goal(Goal(order=1))
    assert graph.failures.refused_calls == 1


async def test_unread_results_are_bounded_and_losses_counted(node: Node, other: Node, graph: Graph) -> None:
    ActionServer(node, Fibonacci, "fib", compute)
    client = client_of(other)
    first = await client.send_goal(Goal(order=1))
    for _ in range(256):
        await client.send_goal(Goal(order=1))
        await anyio.sleep(0.01)
    assert graph.failures.late_answers == 1
    assert (await first.result())[0] is GoalState.UNKNOWN


async def test_the_graph_lists_actions_with_servers_and_clients(node: Node, other: Node, graph: Graph) -> None:
    ActionServer(node, Fibonacci, "fib", compute)
    client_of(other)
    assert graph.actions() == (("/fib", "example_interfaces/action/Fibonacci", ("/node",), ("/other",)),)
    assert graph.get_action_names_and_types() == {"/fib": "example_interfaces/action/Fibonacci"}
    assert graph.get_action_type("/fib") is Fibonacci
    assert graph.get_action_type("/nothing") is None
    assert list(graph.get_service_names_and_types()) == [
        f"/fib/_action/{n}" for n in ("cancel_goal", "get_result", "send_goal")
    ]


async def test_an_offered_action_is_listed_and_its_server_made_when_it_is_used(
    node: Node, other: Node, graph: Graph
) -> None:
    started: list[ActionServer[Goal, Result, Feedback]] = []
    node.offer_action(Fibonacci.ros_type, "fib", lambda: started.append(ActionServer(node, Fibonacci, "fib", compute)))
    with pytest.raises(DuplicateNameError):
        node.offer_action(Fibonacci.ros_type, "fib", lambda: None)
    assert graph.actions() == (("/fib", Fibonacci.ros_type, ("/node",), ()),)
    assert not started
    assert await client_of(other).perform(Goal(order=3)) == Result(sequence=(0, 1, 1))
    assert len(started) == 1
    assert graph.actions() == (("/fib", Fibonacci.ros_type, ("/node",), ("/other",)),)


async def test_an_offered_action_goes_with_its_node(graph: Graph, other: Node) -> None:
    async with Node(graph, "serving") as serving:
        serving.offer_action(Fibonacci.ros_type, "fib", lambda: None)
    assert graph.actions() == ()
    with pytest.raises(ServiceUnavailableError):
        await client_of(other).perform(Goal(order=1))


async def test_an_execution_that_was_preempted_may_still_end_its_goal(node: Node, other: Node, graph: Graph) -> None:
    """A program for ROS cleans up and says how it ended: the goal is aborted already, but its result counts."""
    preempted = []

    async def execute(goal: Served) -> Result:
        try:
            await anyio.sleep(10.0)
        except asyncio.CancelledError:
            preempted.append(goal.is_preempted)
            goal.canceled(Result(sequence=(7,)))
            raise
        goal.succeed()
        return EMPTY

    ActionServer(node, Fibonacci, "fib", execute, preemption=Preemption.ABORT)
    client = client_of(other)
    first, second = await client.send_goal(Goal(order=1)), await client.send_goal(Goal(order=2))
    await anyio.sleep(1.0)
    third = await client.send_goal(Goal(order=3))
    assert await first.result() == (GoalState.ABORTED, EMPTY)
    assert await second.result() == (GoalState.ABORTED, Result(sequence=(7,)))
    assert await third.result() == (GoalState.SUCCEEDED, EMPTY)
    assert preempted == [True]
    assert list(graph.failures) == []
