"""The end of an action that sends goals.

Source: ROS 2, rclpy ``action/client.py``.
"""

from __future__ import annotations

import uuid
from collections.abc import Awaitable, Callable
from functools import partial
from typing import Any, Generic, TypeVar

from homebot.errors import ClosedError, GoalAbortedError, GoalCanceledError, GoalRejectedError
from homebot.graph.actions.client_goal import ClientGoal
from homebot.graph.actions.goal_state import GoalState, endpoint_name
from homebot.graph.endpoint import EndpointInfo, EntityKind, GraphEntity
from homebot.graph.node import Node
from homebot.graph.qos import qos_profile_latched
from homebot.graph.subscription import Subscription
from homebot.messages.action import ActionType
from homebot.messages.action_msgs import CancelGoal, GoalStatusArray
from homebot.messages.message import Message
from homebot.messages.unique_identifier_msgs import UUID

__all__ = ["ActionClient"]

GoalT = TypeVar("GoalT", bound=Message)
ResultT = TypeVar("ResultT", bound=Message)
FeedbackT = TypeVar("FeedbackT", bound=Message)


class ActionClient(Generic[GoalT, ResultT, FeedbackT]):
    """Sends goals of one action. Its goals are cancelled when it closes, or its node.

    Feedback and changes of state arrive while *node* runs.

    Args:
        name: The name of the action; relative, absolute, or private (``~/name``). It need not have a server yet.

    Raises:
        InvalidNameError: *name* is not a legal name.
        TypeMismatchError: The action is of another type.
    """

    def __init__(self, node: Node, action_type: ActionType[GoalT, ResultT, FeedbackT], name: str) -> None:
        self._node = node
        self._type = action_type
        self._goals: dict[bytes, ClientGoal[ResultT, FeedbackT]] = {}
        self._closed = False
        name = node.resolve_name(name, "action name")
        self.info = EndpointInfo(EntityKind.ACTION_CLIENT, node.full_name, name, action_type.ros_type)
        self._endpoint = partial(endpoint_name, name)
        self._sending = node.create_client(action_type.SendGoal, self._endpoint("send_goal"))
        self._canceling = node.create_client(CancelGoal, self._endpoint("cancel_goal"))
        self._results = node.create_client(action_type.GetResult, self._endpoint("get_result"))
        self._subscriptions: tuple[Subscription[Any], ...] = ()
        node.add_entity(self)

    @property
    def action_name(self) -> str:
        """Full name of the action."""
        return self.info.name

    @property
    def has_feedback(self) -> bool:
        """True while feedback has arrived that was not handed to its goal yet."""
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

    async def perform(
        self, goal: GoalT, on_feedback: Callable[[FeedbackT], Awaitable[None] | None] | None = None
    ) -> ResultT:
        """Send *goal* and return its result. Cancelling this cancels the goal.

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
        finally:
            self._goals.pop(sent.goal_id.uuid, None)
        if state is GoalState.SUCCEEDED:
            return result
        if state is GoalState.CANCELED:
            raise GoalCanceledError(self.action_name, result)
        raise GoalAbortedError(self.action_name, result)

    async def send_goal(
        self,
        goal: GoalT,
        on_feedback: Callable[[FeedbackT], Awaitable[None] | None] | None = None,
        *,
        goal_id: UUID | None = None,
    ) -> ClientGoal[ResultT, FeedbackT]:
        """Send *goal* and return it when the server has accepted it.

        Args:
            on_feedback: A function or coroutine function for each feedback message.
            goal_id: By default a random one.

        Raises:
            GoalRejectedError: The server did not accept it.
            ServiceError: The server did not answer, or there is none.
            TypeMismatchError: *goal* is not of the action's goal type.
            ClosedError: The client was closed.
        """
        if self._closed:
            raise ClosedError(f"the action client of {self.info.node} for {self.action_name} is closed")
        self._subscribe()
        goal_id = goal_id or UUID(uuid=uuid.uuid4().bytes)
        result_request = self._type.GetResult.Request(goal_id=goal_id)
        sent = ClientGoal[ResultT, FeedbackT](goal_id, result_request, self._results, self._canceling, on_feedback)
        request = self._type.SendGoal.Request(goal_id=goal_id, goal=goal)
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
        if self._closed:
            return
        self._closed = True
        for goal in tuple(self._goals.values()):
            goal.request_cancel()
        self._goals.clear()
        ends: tuple[GraphEntity, ...] = (self._sending, self._canceling, self._results, *self._subscriptions)
        for end in ends:
            end.close()
        self._node.remove_entity(self)

    def _subscribe(self) -> None:
        if self._subscriptions:
            return
        create, endpoint = self._node.create_subscription, self._endpoint
        self._subscriptions = (
            create(self._type.FeedbackMessage, endpoint("feedback"), self._on_feedback),
            create(GoalStatusArray, endpoint("status"), self._on_states, qos_profile_latched),
        )

    def _on_feedback(self, message: Any) -> Awaitable[None] | None:  # its type is made by the action type
        goal = self._goals.get(message.goal_id.uuid)
        self._forget_ended()
        return None if goal is None or goal.on_feedback is None else goal.on_feedback(message.feedback)

    def _on_states(self, message: GoalStatusArray) -> None:
        for status in message.status_list:
            goal = self._goals.get(status.goal_info.goal_id.uuid)
            if goal is not None:
                goal.status = GoalState(status.status)
        self._forget_ended()

    def _forget_ended(self) -> None:
        """Forget the goals that have ended, unless feedback of theirs may wait."""
        if not self.has_feedback:
            for goal_id in [goal_id for goal_id, goal in self._goals.items() if goal.status.is_terminal]:
                del self._goals[goal_id]
