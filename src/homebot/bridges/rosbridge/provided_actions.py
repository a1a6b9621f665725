"""The actions whose goals a client executes."""

from __future__ import annotations

import asyncio
from functools import partial
from typing import Any, NamedTuple

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    ActionFeedback,
    ActionOperation,
    ActionResult,
    AdvertiseAction,
    frame_text,
)
from homebot.bridges.rosbridge.services import named_values
from homebot.bridges.rosbridge.shared_state import Provisions, SharedState
from homebot.bridges.rosbridge.types import action_type_of, request_from_client
from homebot.errors import PeerError
from homebot.graph.actions import ActionServer, GoalState, ServerGoal
from homebot.messages.json import JsonObject, message_to_text
from homebot.messages.message import Message

__all__ = ["ProvidedActions"]

_GOAL = "action_goal:"


class _Running(NamedTuple):
    goal: ServerGoal[Any, Any, Any]
    end: asyncio.Future[tuple[int, Message | None]]


class ProvidedActions:
    """The actions that one connection of a client serves; the goals of a connection that ends are aborted."""

    def __init__(self, shared: SharedState, outbox: Outbox, provisions: Provisions) -> None:
        self._node, self._limit = shared.node, shared.settings.max_calls
        self._outbox, self._provisions = outbox, provisions
        self._running: dict[str, _Running] = {}
        self._goals = 0

    def advertise(self, op: AdvertiseAction) -> None:
        """Offer an action of the client; the same once more is fine."""
        name = self._node.resolve_name(op.action, "action name")
        action_type = action_type_of(self._node.graph, name, op.type)
        create = partial(ActionServer[Any, Any, Any], on_goal=self._has_room, on_cancel=self._cancel)
        execute = partial(self._execute, op.action)
        self._provisions.add(_key(name), lambda: create(self._node, action_type, name, execute))

    def unadvertise(self, op: ActionOperation) -> None:
        """Withdraw an action; its goals are aborted."""
        if not self._provisions.remove(_key(self._node.resolve_name(op.action, "action name"))):
            raise PeerError(f"action {op.action} is not served by this client")

    def publish_feedback(self, op: ActionFeedback) -> None:
        """Publish feedback of a goal; that of an ended one is ignored."""
        running = self._find(op)
        if running is not None:
            feedback_type = running.goal.action_type.Feedback
            running.goal.publish_feedback(self._read(feedback_type, op.values))

    def end(self, op: ActionResult) -> None:
        """End a goal; a second result is ignored, which roslib sends after it has advertised twice.

        Raises:
            TypeMismatchError: The values do not fit the action; the goal is aborted.
            PeerError: The goal is none of this client's.
        """
        running = self._find(op)
        if running is None or running.end.done():
            return
        end: tuple[int, Message | None] = (GoalState.ABORTED, None)
        try:
            if isinstance(op.values, dict | list):
                result_type = running.goal.action_type.Result
                end = op.status, self._read(result_type, named_values(result_type, op.values))
        finally:
            running.end.set_result(end)

    def _read(self, message_type: type[Message], values: dict[str, Any]) -> Message:
        return request_from_client(message_type, values, self._node.graph.clock.now())

    def _has_room(self, _goal: Message) -> bool:
        return len(self._running) < self._limit and self._outbox.has_room

    def _cancel(self, goal: ServerGoal[Any, Any, Any]) -> bool:
        for identifier, running in self._running.items():
            if running.goal is goal:
                self._ask_to_cancel(identifier)
        return True  # one whose execution is yet to begin is cancelled then

    def _ask_to_cancel(self, identifier: str) -> None:
        action = identifier.rpartition(":")[0].removeprefix(_GOAL)
        self._outbox.answer(frame_text("cancel_action_goal", identifier, {"action": action}))

    def _find(self, op: ActionFeedback | ActionResult) -> _Running | None:
        """Return the goal of this client that *op* is about; None if it has ended."""
        prefix, _, number = str(op.id).rpartition(":")
        if prefix != f"{_GOAL}{op.action}" or not number.isdecimal() or int(number) > self._goals:
            raise PeerError(f"this client executes no goal of {op.action} with the id {op.id!r}")
        return self._running.get(str(op.id))

    async def _execute(self, name: str, goal: ServerGoal[Any, Any, Any]) -> Message | None:
        self._goals += 1
        identifier = f"{_GOAL}{name}:{self._goals}"
        running = self._running[identifier] = _Running(goal, asyncio.get_running_loop().create_future())
        try:
            fields: JsonObject = {"action": name, "action_type": goal.action_type.ros_type, "feedback": True}
            args = message_to_text(goal.request)
            self._outbox.answer(frame_text("send_action_goal", identifier, fields, args=args))
            if goal.is_cancel_requested:
                self._ask_to_cancel(identifier)
            status, result = await running.end
        finally:
            del self._running[identifier]
        if status == GoalState.SUCCEEDED:
            goal.succeed(result)
        elif status == GoalState.CANCELED and goal.is_cancel_requested:
            goal.canceled(result)
        else:
            goal.abort(result)
        return result


def _key(action: str) -> str:
    """Return the name of an action among the servers, where it is no service's."""
    return f"{action}/_action"
