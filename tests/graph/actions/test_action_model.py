"""Goals under random cancellations, preemptions and ends: each ends once, in states that follow each other."""

import asyncio
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import anyio
from hypothesis import given, settings
from hypothesis import strategies as st
from tests.graph.actions.fibonacci import Client, Feedback, Fibonacci, Goal, Result, Served

from homebot.errors import GoalRejectedError, ServiceError
from homebot.graph import Graph, Node, QoSProfile
from homebot.graph.actions import ActionServer, GoalState, Preemption
from homebot.messages.action_msgs import GoalStatusArray
from homebot.testing import VirtualTimeLoop

End = Literal["succeed", "abort", "canceled", "return", "fail", "ignore"]
TENTHS = st.integers(0, 30).map(lambda tenths: tenths / 10)


@dataclass(frozen=True)
class Plan:
    """A goal: when it is sent, cancelled by request or with its task, and how its execution ends."""

    begins: float
    cancelled_after: float | None
    task_ends_after: float | None
    seconds: float
    end: End


PLANS = st.builds(
    Plan,
    begins=TENTHS,
    cancelled_after=st.none() | TENTHS,
    task_ends_after=st.none() | TENTHS,
    seconds=TENTHS,
    end=st.sampled_from(["succeed", "abort", "canceled", "return", "fail", "ignore"]),
)


class Trial:
    """Carries plans out and records the ends of goals, by number, and the states of all."""

    def __init__(self, plans: list[Plan]) -> None:
        self.plans = plans
        self.states: dict[bytes, list[GoalState]] = {}
        self.ends: dict[int, GoalState | None] = {}
        self.running = self.most = 0

    async def run(self, preemption: Preemption | None, closes_after: float, *, handles_cancel: bool) -> int:
        """Run all; the server closes after so many seconds. Return the number of goals that never ended."""
        graph = Graph()
        async with Node(graph, "caller") as caller, Node(graph, "server") as node:
            client = Client(caller, Fibonacci, "fib")
            on_cancel = (lambda _goal: True) if handles_cancel else None
            server = ActionServer(node, Fibonacci, "fib", self._execute, on_cancel=on_cancel, preemption=preemption)
            all_states = QoSProfile(depth=10_000)
            caller.create_subscription(GoalStatusArray, "/fib/_action/status", self._on_states, all_states)
            async with anyio.create_task_group() as tasks:
                for number, plan in enumerate(self.plans):
                    tasks.start_soon(self._follow, client, number, plan)
                await anyio.sleep(closes_after)
                server.close()
            await anyio.sleep(10.0)
            return len(server.goals)

    async def _follow(self, client: Client, number: int, plan: Plan) -> None:
        await anyio.sleep(plan.begins)
        self.ends[number] = None
        with anyio.move_on_after(plan.task_ends_after):
            try:
                goal = await client.send_goal(Goal(order=number))
                async with anyio.create_task_group() as tasks:
                    if plan.cancelled_after is not None:
                        tasks.start_soon(self._cancel, goal.cancel, plan.cancelled_after)
                    self.ends[number] = (await goal.result())[0]
            except* (GoalRejectedError, ServiceError):
                pass

    async def _cancel(self, cancel: Callable[[], Awaitable[object]], seconds: float) -> None:
        await anyio.sleep(seconds)
        await cancel()

    async def _execute(self, goal: Served) -> Result | None:
        plan = self.plans[goal.request.order]
        self.running += 1
        self.most = max(self.most, self.running)
        try:
            await anyio.sleep(plan.seconds)
            goal.publish_feedback(Feedback(sequence=(1,)))
        except asyncio.CancelledError:
            if plan.end != "ignore":
                raise
        finally:
            self.running -= 1
        match plan.end:
            case "succeed" | "abort" | "canceled":
                getattr(goal, plan.end)()
            case "fail":
                raise ValueError("ouch")
        return None

    def _on_states(self, message: GoalStatusArray) -> None:
        for status in message.status_list:
            states = self.states.setdefault(status.goal_info.goal_id.uuid, [])
            if not states or states[-1] != status.status:
                states.append(GoalState(status.status))


@settings(deadline=None)
@given(
    plans=st.lists(PLANS, min_size=1, max_size=15),
    preemption=st.sampled_from([None, *Preemption]),
    closes_after=TENTHS.map(lambda seconds: 3 * seconds),
    handles_cancel=st.booleans(),
)
def test_each_goal_ends_once_and_each_caller_is_answered(
    plans: list[Plan], preemption: Preemption | None, closes_after: float, *, handles_cancel: bool
) -> None:
    trial = Trial(plans)
    with asyncio.Runner(loop_factory=VirtualTimeLoop) as runner:
        unended = runner.run(trial.run(preemption, closes_after, handles_cancel=handles_cancel))
    assert unended == trial.running == 0
    assert preemption is None or trial.most <= 1
    for states in trial.states.values():
        assert states[-1].is_terminal
        pairs = pairwise(states)
        assert all(after is GoalState.ABORTED or before.can_become(after) for before, after in pairs)
    assert all(end is None or end.is_terminal for end in trial.ends.values())
