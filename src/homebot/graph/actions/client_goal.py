"""A goal at its client."""

from __future__ import annotations

import math
from collections.abc import Awaitable, Callable
from typing import Any, Generic, TypeVar

from homebot.graph.actions.goal_state import GoalState
from homebot.graph.client import Client
from homebot.messages.action_msgs import CancelGoalRequest, CancelGoalResponse, GoalInfo
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message
from homebot.messages.unique_identifier_msgs import UUID

__all__ = ["ClientGoal"]

ResultT = TypeVar("ResultT", bound=Message)
FeedbackT = TypeVar("FeedbackT", bound=Message)


class ClientGoal(Generic[ResultT, FeedbackT]):
    """A goal that a client has sent.

    Attributes:
        goal_id: The id that the client chose.
        status: Its newest known state.
        stamp: When the server accepted it.
    """

    def __init__(
        self,
        goal_id: UUID,
        result_request: Message,
        results: Client[Any, Any],
        cancels: Client[CancelGoalRequest, CancelGoalResponse],
        on_feedback: Callable[[FeedbackT], Awaitable[None] | None] | None,
    ) -> None:
        """Use :meth:`homebot.graph.actions.ActionClient.send_goal` instead."""
        self.goal_id = goal_id
        self.status = GoalState.UNKNOWN
        self.stamp = Time(sec=0, nanosec=0)
        self.on_feedback = on_feedback
        self._result_request = result_request
        self._results = results
        self._cancels = cancels
        self._outcome: tuple[GoalState, ResultT] | None = None

    async def result(self) -> tuple[GoalState, ResultT]:
        """Return the final state and the result when the goal has ended; UNKNOWN if the server has forgotten it.

        Raises:
            ServiceUnavailableError: There is no server.
            ServiceGoneError: The server was closed meanwhile.
            ClosedError: The client was closed.
        """
        if self._outcome is None:
            response = await self._results.call(self._result_request, math.inf)
            self.status = GoalState(response.status)
            self._outcome = (self.status, response.result)
        return self._outcome

    async def cancel(self) -> CancelGoalResponse:
        """Ask the server to cancel the goal; the response says whether it will.

        Raises:
            ServiceError: The server did not answer.
        """
        return await self._cancels.call(self._cancel_request())

    def request_cancel(self) -> None:
        """Ask the server to cancel the goal, without waiting for its answer."""
        self._cancels.send(self._cancel_request())

    def _cancel_request(self) -> CancelGoalRequest:
        return CancelGoalRequest(goal_info=GoalInfo(goal_id=self.goal_id, stamp=Time(sec=0, nanosec=0)))
