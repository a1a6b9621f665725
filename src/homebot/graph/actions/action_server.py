"""Server of an action: executes goals.

Source: ROS 2, rclpy ``action/server.py``, rcl_action ``action_server.c``.
"""

import asyncio
from collections.abc import Awaitable, Callable, Iterator
from contextlib import AbstractAsyncContextManager, nullcontext
from enum import StrEnum
from functools import partial
from typing import Any, Final, Generic

import anyio

from homebot.graph.actions.goals import GoalState, ServerGoal, check_type, endpoint_name
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.node import Node
from homebot.graph.qos import qos_profile_latched
from homebot.messages.action import ActionType, FeedbackT, GoalT, ResultT
from homebot.messages.action_msgs import (
    CancelGoal,
    CancelGoalRequest,
    CancelGoalResponse,
    GoalInfo,
    GoalStatus,
    GoalStatusArray,
)
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import zero_message
from homebot.messages.message import Message
from homebot.messages.unique_identifier_msgs import UUID
from homebot.support.isolation import crash_of, is_end_of, uncancel
from homebot.support.time_limits import TimeLimits

MAX_ACTIVE: Final = 256
MAX_ENDED: Final = 256
_NO_ID: Final = bytes(16)
_NO_TIME: Final = (0, 0)

NO_TERMINAL_STATE: Final = "graph.goal_without_end"


class Preemption(StrEnum):
    """Rule for active goals when another goal arrives."""

    REJECT = "reject"
    ABORT = "abort"
    QUEUE = "queue"


class ActionServer(GraphEntity, Generic[GoalT, ResultT, FeedbackT]):
    """Executes the goals of one action; at most 256 are active at once, and refused ones are counted like calls.

    *execute* ends its goal by ``succeed``, ``abort`` or ``canceled`` and returns the result. Without one of these the
    goal is ABORTED with a warning; after an exception it is ABORTED with an empty result, and the failure is counted.
    The last 256 results are kept for *result_timeout*; results dropped earlier are counted as late answers.

    Args:
        node: The node that executes the goals while it runs.
        name: The name of the action; relative, absolute, or private (``~/name``).
        on_goal: Returns whether to accept a goal; all are accepted by default.
        on_cancel: Returns whether to accept the cancellation of a goal, whose execution then has to end by itself; by
            default a cancellation is accepted and cancels the execution.
        preemption: The rule for a goal that arrives while another one is active; by default both are executed.
        result_timeout: Seconds after the end of a goal.

    Raises:
        InvalidNameError: *name* is not a legal name.
        DuplicateNameError: Another server has the name.
        TypeMismatchError: The action is of another type.
    """

    def __init__(
        self,
        node: Node,
        action_type: ActionType[GoalT, ResultT, FeedbackT],
        name: str,
        execute: Callable[[ServerGoal[GoalT, ResultT, FeedbackT]], Awaitable[ResultT | None]],
        *,
        on_goal: Callable[[GoalT], bool] | None = None,
        on_cancel: Callable[[ServerGoal[GoalT, ResultT, FeedbackT]], bool] | None = None,
        preemption: Preemption | None = None,
        result_timeout: float = 10.0,
    ) -> None:
        self._node = node
        self._type = action_type
        self._execute = execute
        self._on_goal = on_goal
        self._on_cancel = on_cancel
        self._preemption = preemption
        self._result_timeout = result_timeout
        self._goals: dict[bytes, ServerGoal[GoalT, ResultT, FeedbackT]] = {}  # in order of acceptance
        self._expiries = TimeLimits()
        self._turn: AbstractAsyncContextManager[None] = nullcontext() if preemption is None else anyio.Lock()
        name = node.resolve_name(name, "action name")
        info = EndpointInfo(EntityKind.ACTION_SERVER, node.full_name, name, action_type.ros_type)
        super().__init__(info, node.remove_entity)
        endpoint = partial(endpoint_name, name)
        self._sending = node.create_service(action_type.SendGoal, endpoint("send_goal"), self._accept, concurrent=True)
        self._canceling = node.create_service(CancelGoal, endpoint("cancel_goal"), self._cancel, concurrent=True)
        self._results = node.create_service(
            action_type.GetResult, endpoint("get_result"), self._answer, concurrent=True, cancel_with_caller=True
        )
        self._feedback = node.create_publisher(action_type.FeedbackMessage, endpoint("feedback"))
        self._status = node.create_publisher(GoalStatusArray, endpoint("status"), qos_profile_latched)
        node.add_entity(self)

    @property
    def action_name(self) -> str:
        """Full name of the action."""
        return self.info.name

    @property
    def goals(self) -> tuple[ServerGoal[GoalT, ResultT, FeedbackT], ...]:
        """The active goals, in order of acceptance."""
        return tuple(goal for goal in self._goals.values() if goal.is_active)

    def close(self) -> None:
        """Leave the graph: active goals are ABORTED, and callers waiting for their results are answered. Idempotent."""
        if self.is_closed:
            return
        for goal in self._goals.values():
            if goal.is_active or goal.is_preempted:
                goal.revoke()
        super().close()
        self._results.close(finish=True)
        for end in (self._sending, self._canceling, self._feedback, self._status):
            end.close()

    def _accept(self, request: Any) -> Message:  # the action type creates the types of the request and the response
        stamp = Time.from_seconds(self._node.graph.clock.now())
        accepted = self._is_acceptable(request.goal_id.uuid) and (self._on_goal is None or self._on_goal(request.goal))
        if accepted:
            if self._preemption is Preemption.ABORT:
                for goal in self.goals:
                    goal.preempt()
            info = GoalInfo(goal_id=request.goal_id, stamp=stamp)
            goal = ServerGoal(self._type, request.goal, info, self._publish_states, self._publish_feedback)
            self._goals[request.goal_id.uuid] = goal
            self._publish_states()
            self._node.create_task(partial(self._run, goal))
        response: Message = self._type.SendGoal.Response(accepted=accepted, stamp=stamp)
        return response

    def _is_acceptable(self, goal_id: bytes) -> bool:
        active = len(self.goals)
        if active >= MAX_ACTIVE:
            self._node.graph.failures.refused_calls += 1
            return False
        return goal_id not in self._goals and not (active and self._preemption is Preemption.REJECT)

    def _cancel(self, request: CancelGoalRequest) -> CancelGoalResponse:
        goal_id, at = request.goal_info.goal_id.uuid, _time_of(request.goal_info)
        named = self._goals.get(goal_id)
        is_one = goal_id != _NO_ID and at == _NO_TIME
        meant = self._named_or_until(named, at, is_one=is_one)
        goals = [goal for goal in meant if goal.state.can_become(GoalState.CANCELING)]
        canceling = tuple(goal.info for goal in goals if self._cancel_goal(goal))
        code = CancelGoalResponse.ERROR_NONE
        if goals and not canceling:
            code = CancelGoalResponse.ERROR_REJECTED
        elif is_one and not goals:
            code = CancelGoalResponse.ERROR_GOAL_TERMINATED if named else CancelGoalResponse.ERROR_UNKNOWN_GOAL_ID
        return CancelGoalResponse(return_code=code, goals_canceling=canceling)

    def _named_or_until(
        self, named: ServerGoal[GoalT, ResultT, FeedbackT] | None, at: tuple[int, int], *, is_one: bool
    ) -> Iterator[ServerGoal[GoalT, ResultT, FeedbackT]]:
        """Yield the *named* goal and, unless that *is_one* alone, those accepted until *at*, which may be any time."""
        for goal in self._goals.values():
            if goal is named or (not is_one and (at == _NO_TIME or _time_of(goal.info) <= at)):
                yield goal

    def _cancel_goal(self, goal: ServerGoal[GoalT, ResultT, FeedbackT]) -> bool:
        """Cancel *goal* if its server agrees; return whether it does."""
        is_waiting = self._preemption is not None and goal.state is GoalState.ACCEPTED
        if self._on_cancel is not None and not is_waiting and not self._on_cancel(goal):
            return False
        goal.change_state(GoalState.CANCELING)
        if self._on_cancel is None or is_waiting:
            goal.scope.cancel()
        return True

    async def _answer(self, request: Any) -> Message:  # as above
        goal = self._goals.get(request.goal_id.uuid)
        result = zero_message(self._type.Result) if goal is None else await asyncio.shield(goal.outcome)
        status = int(GoalState.UNKNOWN if goal is None else goal.state)
        response: Message = self._type.GetResult.Response(status=status, result=result)
        return response

    async def _run(self, goal: ServerGoal[GoalT, ResultT, FeedbackT]) -> None:
        """Execute *goal*; in any case it ends and has a result."""
        result: ResultT | None = None
        try:
            with goal.scope:
                async with self._turn:
                    result = await self._run_isolated(goal)
            if goal.scope.cancel_called and goal.is_cancel_requested:
                goal.canceled(result)
            elif goal.is_active:
                problem = "returned without succeed(), abort() or canceled(); it counts as aborted"
                self._node.log.warning(
                    NO_TERMINAL_STATE, message=f"the execution of a goal of {self.action_name} {problem}"
                )
                goal.abort(result)
        finally:
            if goal.is_active:  # the node ends
                goal.revoke()
            goal.finish(result)
            self._retain(goal)

    async def _run_isolated(self, goal: ServerGoal[GoalT, ResultT, FeedbackT]) -> ResultT | None:
        """Return the result of the execution; a failure aborts the goal."""
        task = asyncio.current_task()
        try:
            if goal.scope.cancel_called:
                return None
            if goal.state is GoalState.ACCEPTED:
                goal.change_state(GoalState.EXECUTING)
            return check_type(await self._execute(goal), self._type.Result)
        except BaseException as exc:  # every failure but the end of this task
            if is_end_of(task, exc):
                raise
            if isinstance(exc, asyncio.CancelledError):
                uncancel()
            name, crash = self._node.full_name, crash_of(self._node.full_name, exc)
            self._node.graph.failures.record(name, f"execution of {self.action_name}", crash, "its goal is aborted")
            if goal.is_active:
                goal.abort(zero_message(self._type.Result))
            return None

    def _retain(self, goal: ServerGoal[GoalT, ResultT, FeedbackT]) -> None:
        """Keep the result of an ended *goal* for a while."""
        if self.is_closed:
            return
        self._expiries.set(self._result_timeout, partial(self._forget, goal))
        ended = [other for other in self._goals.values() if not other.is_active]
        if len(ended) > MAX_ENDED:
            self._node.graph.failures.late_answers += 1
            self._forget(ended[0])

    def _forget(self, goal: ServerGoal[GoalT, ResultT, FeedbackT]) -> None:
        if self._goals.get(goal.goal_id.uuid) is goal:
            del self._goals[goal.goal_id.uuid]
            self._publish_states()

    def _publish_states(self) -> None:
        if self.is_closed:
            return
        states = tuple(GoalStatus(goal_info=goal.info, status=int(goal.state)) for goal in self._goals.values())
        self._status.publish(GoalStatusArray(status_list=states))

    def _publish_feedback(self, goal_id: UUID, feedback: FeedbackT) -> None:
        self._feedback.publish(self._type.FeedbackMessage(goal_id=goal_id, feedback=feedback))


def _time_of(info: GoalInfo) -> tuple[int, int]:
    return info.stamp.sec, info.stamp.nanosec
