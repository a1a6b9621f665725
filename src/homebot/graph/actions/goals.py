"""Goals of an action: their states, and a goal at its server.

Source: ROS 2, rcl_action ``goal_state_machine.c`` and ``names.c``, action_msgs/GoalStatus.
"""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from enum import IntEnum
from typing import Final, Generic, TypeVar

import anyio

from homebot.errors import TypeMismatchError, UsageError
from homebot.messages.action import ActionType, FeedbackT, GoalT, ResultT
from homebot.messages.action_msgs import GoalInfo
from homebot.messages.definition import zero_message
from homebot.messages.message import Message
from homebot.messages.unique_identifier_msgs import UUID

MessageT = TypeVar("MessageT", bound=Message)


class GoalState(IntEnum):
    """The state of a goal, by the numbers of ``action_msgs/msg/GoalStatus``."""

    UNKNOWN = 0
    ACCEPTED = 1
    EXECUTING = 2
    CANCELING = 3
    SUCCEEDED = 4
    CANCELED = 5
    ABORTED = 6

    @property
    def is_terminal(self) -> bool:
        """True if the goal has ended."""
        return self >= GoalState.SUCCEEDED

    def can_become(self, state: GoalState) -> bool:
        """Return whether *state* may follow."""
        return state in _NEXT.get(self, ())


_NEXT: Final = {
    GoalState.ACCEPTED: (GoalState.EXECUTING, GoalState.CANCELING),
    GoalState.EXECUTING: (GoalState.CANCELING, GoalState.SUCCEEDED, GoalState.ABORTED),
    GoalState.CANCELING: (GoalState.SUCCEEDED, GoalState.CANCELED, GoalState.ABORTED),
}


def endpoint_name(action: str, endpoint: str) -> str:
    """Return the full name of one of the five endpoints of *action*."""
    return f"{action}/_action/{endpoint}"


class ServerGoal(Generic[GoalT, ResultT, FeedbackT]):
    """An accepted goal at its server.

    Attributes:
        state: Its state; the server publishes each change.
        outcome: Its result, once it has ended.
        is_preempted: Whether another goal replaced it. It is ABORTED then; its execution can still give it a result.
    """

    def __init__(
        self,
        action_type: ActionType[GoalT, ResultT, FeedbackT],
        request: GoalT,
        info: GoalInfo,
        on_change: Callable[[], None],
        on_feedback: Callable[[UUID, FeedbackT], None],
    ) -> None:
        """Use :class:`homebot.graph.actions.ActionServer` instead."""
        self.action_type = action_type
        self.request = request
        self.info = info
        self.state = GoalState.ACCEPTED
        self.scope = anyio.CancelScope()
        self.outcome: asyncio.Future[ResultT] = asyncio.get_running_loop().create_future()
        self._on_change = on_change
        self._on_feedback = on_feedback
        self.is_preempted = False
        self._has_ended_early = False

    @property
    def goal_id(self) -> UUID:
        """The id that its client chose."""
        return self.info.goal_id

    @property
    def is_active(self) -> bool:
        """True until it has ended."""
        return not self.state.is_terminal

    @property
    def is_cancel_requested(self) -> bool:
        """True if a request to cancel it was accepted."""
        return self.state is GoalState.CANCELING

    def publish_feedback(self, feedback: FeedbackT) -> None:
        """Publish *feedback* to the clients; ignored after the end of the goal.

        Raises:
            TypeMismatchError: *feedback* is not of the action's feedback type.
        """
        check_type(feedback, self.action_type.Feedback)
        if self.is_active:
            self._on_feedback(self.goal_id, feedback)

    def succeed(self, result: ResultT | None = None) -> None:
        """End the goal as SUCCEEDED.

        Args:
            result: The message that the execution returns, by default.

        Raises:
            TypeMismatchError: *result* is not of the action's result type.
            UsageError: The goal has ended already. Nothing is raised if the server ended it.
        """
        self._end(GoalState.SUCCEEDED, result)

    def abort(self, result: ResultT | None = None) -> None:
        """End the goal as ABORTED; see :meth:`succeed`."""
        self._end(GoalState.ABORTED, result)

    def canceled(self, result: ResultT | None = None) -> None:
        """End the goal as CANCELED, if a request for that was accepted; see :meth:`succeed`."""
        self._end(GoalState.CANCELED, result)

    # The methods below are for the server.

    def change_state(self, state: GoalState) -> None:
        """Enter *state*.

        Raises:
            UsageError: It cannot follow the present state.
        """
        if not self.state.can_become(state):
            raise UsageError(f"a goal that is {self.state.name} cannot become {state.name}")
        self.state = state
        self._on_change()

    def preempt(self) -> None:
        """Abort the goal as another one replaces it, and cancel its execution, whose result counts."""
        self.is_preempted = True
        self._end_early()
        self.scope.cancel()

    def revoke(self) -> None:
        """Abort the goal, without a result, as its server ends, and cancel its execution."""
        if self.is_active:
            self._end_early()
        self.finish(None)
        self.scope.cancel()

    def finish(self, result: ResultT | None) -> None:
        """Fix the result of an ended goal: the one it ended with, else *result*, else an empty one."""
        if not self.outcome.done():
            self.outcome.set_result(result or zero_message(self.action_type.Result))

    def _end_early(self) -> None:
        self._has_ended_early = True
        self.state = GoalState.ABORTED
        self._on_change()

    def _end(self, state: GoalState, result: ResultT | None) -> None:
        check_type(result, self.action_type.Result)
        if not self._has_ended_early:
            self.change_state(state)
        if result is not None:
            self.finish(result)


def check_type(message: MessageT | None, message_type: type[MessageT]) -> MessageT | None:
    """Return *message* if it is of *message_type*, or None."""
    if message is None or type(message) is message_type:
        return message
    raise TypeMismatchError(f"expected a {message_type.ros_type}, got a {type(message).__name__}")
