"""The goals that nodes of robots have at actions of homebot."""

from __future__ import annotations

import math
from collections.abc import Callable, Coroutine
from contextlib import suppress
from itertools import chain
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from homebot.errors import GoalRejectedError, PeerError
from homebot.graph import Node
from homebot.graph.actions import ActionClient, ClientGoal
from homebot.messages.action_msgs import CancelGoalRequest, CancelGoalResponse
from homebot.messages.definition import zero_message
from homebot.messages.message import Message

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.access import ClientAccess

_Client = ActionClient[Any, Any, Any]
_Goal = ClientGoal[Any, Any]
_NO_ID: Final = bytes(16)


class Caller(NamedTuple):
    """A node of a robot, by the Zenoh id of its process and its full name; both are empty if it is unknown."""

    session: str
    node: str


class RobotGoals:
    """Answers the three services of each exported action; the goals of a node of a robot are cancelled when it leaves.

    A node can cancel, and ask the results of, only the goals that it sent; another process with a node of its name
    does not keep them.

    Args:
        is_there: Whether a node has a token now.
    """

    def __init__(self, node: Node, is_there: Callable[[Caller], bool]) -> None:
        self._node, self._is_there = node, is_there
        self._clients: dict[tuple[Caller, str], _Client] = {}

    async def answer(self, service: str, request: Any, caller: Caller, access: ClientAccess) -> Message:
        """Return the response of the full name *service* to *request* from the node *caller*.

        Raises:
            PeerError: The caller has no token, so its leaving would not be noticed.
            ServiceError: The action has no server, or its server did not answer.
        """
        action, _, part = service.partition("/_action/")
        if not self._is_there(caller):
            raise PeerError(f"a goal of {action} comes from a node without a token; it has to declare one first")
        client = self._clients.get((caller, action))
        if client is None:
            action_type = self._node.graph.get_action_type(action)
            if action_type is None:
                raise PeerError(f"the action {action} has no server now")
            client = self._clients[caller, action] = ActionClient(self._node, action_type, action)
        if part == "send_goal":
            return await _send(client, request, access)
        return await _ANSWERS[part](client, request)

    def end_of_all_that_left(self) -> None:
        """Cancel the goals of nodes that have left."""
        for key in [key for key in self._clients if not self._is_there(key[0])]:
            self._clients.pop(key).close()


async def _send(client: _Client, request: Any, access: ClientAccess) -> Message:
    response_type: type[Message] = client.action_type.SendGoal.Response
    response: Message = zero_message(response_type)
    with suppress(GoalRejectedError):
        goal = await client.send_goal(access.as_own(request.goal), goal_id=request.goal_id)
        response = response_type.model_validate({"accepted": True, "stamp": goal.stamp})
    return response


async def _result(client: _Client, request: Any) -> Message:
    """Return the response at the end of the goal; its status is unknown if the node has no such goal."""
    response_type: type[Message] = client.action_type.GetResult.Response
    response: Message = zero_message(response_type)
    for goal in client.goals:
        if goal.goal_id == request.goal_id:
            state, result = await goal.result()
            response = response_type.model_validate({"status": int(state), "result": result})
    return response


async def _cancel(client: _Client, request: CancelGoalRequest) -> Message:
    wanted, at = request.goal_info.goal_id, request.goal_info.stamp.to_seconds()
    is_one = wanted.uuid != _NO_ID and not at
    latest = -math.inf if is_one else at or math.inf
    chosen = [goal for goal in client.goals if goal.goal_id == wanted or goal.stamp.to_seconds() <= latest]
    answers = [await goal.cancel() for goal in chosen]
    unknown = CancelGoalResponse.ERROR_UNKNOWN_GOAL_ID if is_one else CancelGoalResponse.ERROR_NONE
    return CancelGoalResponse(
        return_code=min((answer.return_code for answer in answers), default=unknown),
        goals_canceling=tuple(chain.from_iterable(answer.goals_canceling for answer in answers)),
    )


_ANSWERS: Final[dict[str, Callable[[_Client, Any], Coroutine[Any, Any, Message]]]] = {
    "get_result": _result,
    "cancel_goal": _cancel,
}
