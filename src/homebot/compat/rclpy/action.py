"""Actions in the form of rclpy.

Executions, feedback and results arrive on the thread that spins. The callbacks that accept goals and cancellations run
on the graph's event loop, so that a goal can be cancelled while its execution blocks; do not wait in them.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import IntEnum
from functools import partial
from types import SimpleNamespace
from typing import Any

from homebot.compat.interfaces import AnyAction, InterfaceMessage, from_message, to_action, to_message
from homebot.compat.rclpy.context import CONTEXT
from homebot.compat.rclpy.node import Node, later
from homebot.compat.rclpy.task import Future
from homebot.errors import GoalRejectedError
from homebot.graph.actions import ActionClient as GraphActionClient
from homebot.graph.actions import ActionServer as GraphActionServer
from homebot.graph.actions import ClientGoal, GoalState, ServerGoal
from homebot.messages.action import ActionType
from homebot.messages.message import Message

__all__ = ["ActionClient", "ActionServer", "CancelResponse", "ClientGoalHandle", "GoalResponse", "ServerGoalHandle"]


class GoalResponse(IntEnum):
    """The answer to a goal."""

    REJECT = 1
    ACCEPT = 2


class CancelResponse(IntEnum):
    """The answer to a request to cancel a goal."""

    REJECT = 1
    ACCEPT = 2


class ServerGoalHandle:
    """A goal at its server.

    Attributes:
        request: The goal.
    """

    def __init__(self, goal: ServerGoal[Any, Any, Any], kind: ActionType[Any, Any, Any]) -> None:
        self.request: Any = from_message(goal.request)
        self.goal_id = goal.goal_id
        self._goal = goal
        self._kind = kind

    @property
    def is_cancel_requested(self) -> bool:
        """True if a request to cancel it was accepted."""
        return self._goal.is_cancel_requested

    @property
    def is_active(self) -> bool:
        """True until it has ended."""
        return self._goal.is_active

    @property
    def status(self) -> GoalState:
        """Its state."""
        return self._goal.state

    def publish_feedback(self, feedback: InterfaceMessage | Message) -> None:
        """Publish *feedback* to the clients."""
        CONTEXT.call(partial(self._goal.publish_feedback, to_message(feedback, self._kind.Feedback)))

    def succeed(self) -> None:
        """End the goal as SUCCEEDED, with the result that the execution returns."""
        CONTEXT.call(self._goal.succeed)

    def abort(self) -> None:
        """End the goal as ABORTED, likewise."""
        CONTEXT.call(self._goal.abort)

    def canceled(self) -> None:
        """End the goal as CANCELED, likewise."""
        CONTEXT.call(self._goal.canceled)


class ActionServer:
    """Executes the goals of one action.

    Args:
        execute_callback: Takes a :class:`ServerGoalHandle`, ends it and returns the result.
        goal_callback: Takes a goal and returns a :class:`GoalResponse`; by default each is accepted.
        cancel_callback: Takes a goal's handle and returns a :class:`CancelResponse`; by default each is rejected.
        result_timeout: Seconds for which a result is kept.
    """

    def __init__(
        self,
        node: Node,
        action_type: AnyAction,
        action_name: str,
        execute_callback: Callable[[Any], object],
        *,
        goal_callback: Callable[[Any], GoalResponse] | None = None,
        cancel_callback: Callable[[Any], CancelResponse] | None = None,
        result_timeout: float = 10.0,
    ) -> None:
        kind: ActionType[Any, Any, Any] = to_action(action_type).action_type

        async def execute(goal: ServerGoal[Any, Any, Any]) -> Message:
            result: Any = await node.callbacks.run(execute_callback, ServerGoalHandle(goal, kind))
            return to_message(result, kind.Result)

        def on_goal(goal: Message) -> bool:
            return goal_callback is None or goal_callback(from_message(goal)) is GoalResponse.ACCEPT

        def on_cancel(goal: ServerGoal[Any, Any, Any]) -> bool:
            handle = ServerGoalHandle(goal, kind)
            return cancel_callback is not None and cancel_callback(handle) is CancelResponse.ACCEPT

        make = partial(GraphActionServer, node.graph_node, kind, action_name, execute)
        self._server = CONTEXT.call(partial(make, on_goal=on_goal, on_cancel=on_cancel, result_timeout=result_timeout))

    def destroy(self) -> None:
        """Leave the graph; active goals are aborted."""
        CONTEXT.call(self._server.close)


class ClientGoalHandle:
    """A goal at its client.

    Attributes:
        accepted: Whether the server took it.
    """

    def __init__(self, node: Node, goal: ClientGoal[Any, Any] | None) -> None:
        self.accepted = goal is not None
        self._node = node
        self._goal = goal

    @property
    def status(self) -> GoalState:
        """Its newest known state."""
        return GoalState.UNKNOWN if self._goal is None else self._goal.status

    def get_result_async(self) -> Future[Any]:
        """Return the future ``status`` and ``result``."""
        return later(
            self._node,
            self._accepted().result,
            lambda outcome: SimpleNamespace(status=int(outcome[0]), result=from_message(outcome[1])),
        )

    def cancel_goal_async(self) -> Future[Any]:
        """Ask the server to cancel the goal; return the future ``action_msgs/srv/CancelGoal_Response``."""
        return later(self._node, self._accepted().cancel)

    def _accepted(self) -> ClientGoal[Any, Any]:
        if self._goal is None:
            raise GoalRejectedError("the action")
        return self._goal


class ActionClient:
    """Sends goals of one action."""

    def __init__(self, node: Node, action_type: AnyAction, action_name: str) -> None:
        self._node = node
        self._kind: ActionType[Any, Any, Any] = to_action(action_type).action_type
        self._client = CONTEXT.call(partial(GraphActionClient, node.graph_node, self._kind, action_name))

    def server_is_ready(self) -> bool:
        """Return whether the action has a server."""
        return self._client.server_is_ready()

    def wait_for_server(self, timeout_sec: float | None = None) -> bool:
        """Return whether the action has a server within *timeout_sec* seconds."""
        return CONTEXT.wait(partial(self._client.wait_for_server, timeout_sec))

    def send_goal_async(
        self, goal: InterfaceMessage | Message, feedback_callback: Callable[[Any], object] | None = None
    ) -> Future[Any]:
        """Send *goal*; return the future :class:`ClientGoalHandle`.

        Args:
            feedback_callback: Takes each message of feedback, in its attribute ``feedback``.

        Raises:
            TypeMismatchError: *goal* is of another type, or a field has a wrong value.
        """
        message = to_message(goal, self._kind.Goal)

        async def on_feedback(feedback: Message) -> None:
            if feedback_callback is not None:
                await self._node.callbacks.run(feedback_callback, SimpleNamespace(feedback=from_message(feedback)))

        async def send() -> ClientGoal[Any, Any] | None:
            try:
                return await self._client.send_goal(message, on_feedback)
            except GoalRejectedError:
                return None

        return later(self._node, send, partial(ClientGoalHandle, self._node))

    def destroy(self) -> None:
        """Leave the graph; goals that have not ended are cancelled."""
        CONTEXT.call(self._client.close)
