"""Client of an action: sends goals.

Source: ROS 2, rclpy ``action/client.py``.
"""

from __future__ import annotations

import math
import uuid
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, Generic, TypeAlias

from homebot.errors import ClosedError, GoalAbortedError, GoalCanceledError, GoalRejectedError
from homebot.graph.actions.goals import GoalState, endpoint_name
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.node import Node
from homebot.graph.qos import qos_profile_latched
from homebot.graph.subscription import Subscription
from homebot.messages.action import ActionType, FeedbackT, GoalT, ResultT
from homebot.messages.action_msgs import CancelGoal, CancelGoalRequest, CancelGoalResponse, GoalInfo, GoalStatusArray
from homebot.messages.builtin_interfaces import Time
from homebot.messages.unique_identifier_msgs import UUID

_OnFeedback: TypeAlias = Callable[[FeedbackT], Awaitable[None] | None] | None
_NO_TIME = Time(sec=0, nanosec=0)


class ClientGoal(Generic[ResultT, FeedbackT]):
    """A goal that a client has sent."""

    def __init__(
        self, client: ActionClient[Any, ResultT, FeedbackT], goal_id: UUID, on_feedback: _OnFeedback[FeedbackT]
    ) -> None:
        """Use :meth:`homebot.graph.actions.ActionClient.send_goal` instead."""
        self.goal_id = goal_id
        self.status = GoalState.UNKNOWN
        self.stamp = _NO_TIME
        self.on_feedback = on_feedback
        self._client = client
        self._cancel_request = CancelGoalRequest(goal_info=GoalInfo(goal_id=goal_id, stamp=_NO_TIME))
        self._outcome: tuple[GoalState, ResultT] | None = None

    async def result(self) -> tuple[GoalState, ResultT]:
        """Wait for the end of the goal; return its final state and result, or UNKNOWN if the server has forgotten it.

        Raises:
            ServiceUnavailableError: There is no server.
            ServiceGoneError: The server was closed meanwhile.
            ClosedError: The client was closed.
        """
        if self._outcome is None:
            request = self._client.action_type.GetResult.Request(goal_id=self.goal_id)
            response = await self._client.results.call(request, math.inf)
            self.status = GoalState(response.status)
            self._outcome = (self.status, response.result)
        return self._outcome

    async def cancel(self) -> CancelGoalResponse:
        """Ask the server to cancel the goal; the response says whether it will.

        Raises:
            ServiceError: The server did not answer.
        """
        return await self._client.canceling.call(self._cancel_request)

    def request_cancel(self) -> None:
        """Ask the server to cancel the goal, without waiting for its answer."""
        self._client.canceling.send(self._cancel_request)


class ActionClient(GraphEntity, Generic[GoalT, ResultT, FeedbackT]):
    """Sends goals of one action. Its goals are cancelled when it or its node closes.

    Feedback and changes of state arrive while *node* runs.

    Args:
        name: The name of the action; relative, absolute, or private (``~/name``). It need not have a server yet.

    Raises:
        InvalidNameError: *name* is not a legal name.
        TypeMismatchError: The action is of another type.
    """

    def __init__(self, node: Node, action_type: ActionType[GoalT, ResultT, FeedbackT], name: str) -> None:
        self._node = node
        self.action_type = action_type
        self._goals: dict[bytes, ClientGoal[ResultT, FeedbackT]] = {}
        name = node.resolve_name(name, "action name")
        info = EndpointInfo(EntityKind.ACTION_CLIENT, node.full_name, name, action_type.ros_type)
        super().__init__(info, node.remove_entity)
        self._endpoint = partial(endpoint_name, name)
        self._sending = node.create_client(action_type.SendGoal, self._endpoint("send_goal"))
        self.canceling = node.create_client(CancelGoal, self._endpoint("cancel_goal"))
        self.results = node.create_client(action_type.GetResult, self._endpoint("get_result"))
        self._subscriptions: tuple[Subscription[Any], ...] = ()
        node.add_entity(self)

    @property
    def action_name(self) -> str:
        """Full name of the action."""
        return self.info.name

    @property
    def goals(self) -> tuple[ClientGoal[ResultT, FeedbackT], ...]:
        """Its goals that the server has not dropped yet, in the order in which they were sent."""
        return tuple(self._goals.values())

    @property
    def has_feedback(self) -> bool:
        """True while received feedback has not been delivered to its goal yet."""
        return bool(self._subscriptions and self._subscriptions[0].mailbox.waiting)

    def server_is_ready(self) -> bool:
        """Return whether the action has a server now."""
        return self._sending.service_is_ready()

    async def wait_for_server(self, timeout: float | None = None) -> bool:  # noqa: ASYNC109  # rclpy's spelling
        """Wait until the action has a server; return False after *timeout* seconds.

        Raises:
            ClosedError: The client is closed.
        """
        return await self._sending.wait_for_service(timeout)

    async def perform(self, goal: GoalT, on_feedback: _OnFeedback[FeedbackT] = None) -> ResultT:
        """Send *goal* and return its result. Cancelling the caller cancels the goal.

        Raises:
            GoalRejectedError, GoalAbortedError, GoalCanceledError: The goal did not succeed.
            ServiceError: There is no server, or it was closed.
        """
        sent = await self.send_goal(goal, on_feedback)
        try:
            state, result = await sent.result()
        except BaseException:
            sent.request_cancel()
            raise
        if state is GoalState.SUCCEEDED:
            return result
        error = GoalCanceledError if state is GoalState.CANCELED else GoalAbortedError
        raise error(self.action_name, result)

    async def send_goal(
        self, goal: GoalT, on_feedback: _OnFeedback[FeedbackT] = None, *, goal_id: UUID | None = None
    ) -> ClientGoal[ResultT, FeedbackT]:
        """Send *goal* and return it once the server has accepted it.

        Args:
            on_feedback: A function or coroutine function for each feedback message.
            goal_id: A random id by default.

        Raises:
            GoalRejectedError: The server did not accept it, or a goal with this id was sent before.
            ServiceError: The server did not answer, or there is none.
            TypeMismatchError: *goal* is not of the action's goal type.
            ClosedError: The client was closed.
        """
        if self.is_closed:
            raise ClosedError(f"the action client of {self.info.node} for {self.action_name} is closed")
        await self._node.graph.begin(self.action_name)
        self._subscribe()
        goal_id = goal_id or UUID(uuid=uuid.uuid4().bytes)
        if goal_id.uuid in self._goals:  # the first goal remains one of this client
            raise GoalRejectedError(self.action_name)
        sent = ClientGoal[ResultT, FeedbackT](self, goal_id, on_feedback)
        request = self.action_type.SendGoal.Request(goal_id=goal_id, goal=goal)
        self._goals[goal_id.uuid] = sent
        try:
            response = await self._sending.call(request)
        except BaseException:
            self._goals.pop(goal_id.uuid, None)
            sent.request_cancel()  # the server may have accepted it
            raise
        if not response.accepted:
            self._goals.pop(goal_id.uuid, None)
            raise GoalRejectedError(self.action_name)
        sent.stamp = response.stamp
        if sent.status is GoalState.UNKNOWN:
            sent.status = GoalState.ACCEPTED
        return sent

    def close(self) -> None:
        """Leave the graph and cancel the goals that have not ended. Idempotent."""
        if self.is_closed:
            return
        for goal in self._goals.values():
            if not goal.status.is_terminal:
                goal.request_cancel()
        self._goals = {}
        ends: tuple[GraphEntity, ...] = (self._sending, self.canceling, self.results, *self._subscriptions)
        for end in ends:
            end.close()
        super().close()

    def _subscribe(self) -> None:
        if self._subscriptions:
            return
        create, endpoint = self._node.create_subscription, self._endpoint
        self._subscriptions = (
            create(self.action_type.FeedbackMessage, endpoint("feedback"), self._on_feedback),
            create(GoalStatusArray, endpoint("status"), self._on_states, qos_profile_latched),
        )

    def _on_feedback(self, message: Any) -> Awaitable[None] | None:  # the action type creates its type
        goal = self._goals.get(message.goal_id.uuid)
        return None if goal is None or goal.on_feedback is None else goal.on_feedback(message.feedback)

    def _on_states(self, message: GoalStatusArray) -> None:
        """Record the states of goals; an ended goal is kept until the server drops it, for queued feedback."""
        states = {status.goal_info.goal_id.uuid: GoalState(status.status) for status in message.status_list}
        for goal_id, goal in list(self._goals.items()):
            goal.status = states.get(goal_id, goal.status)
            if goal.status.is_terminal and goal_id not in states:
                del self._goals[goal_id]
