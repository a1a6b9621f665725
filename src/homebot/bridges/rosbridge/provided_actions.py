"""The actions whose goals a client executes."""

from __future__ import annotations

import asyncio
from collections.abc import Callable
from typing import Any

from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    ActionFeedback,
    ActionResult,
    AdvertiseAction,
    UnadvertiseAction,
    action_cancellation,
    action_goal,
)
from homebot.bridges.rosbridge.provided_services import Provider
from homebot.bridges.rosbridge.types import action_type_of, partial_message_from_client
from homebot.errors import PeerError
from homebot.graph import Node
from homebot.graph.actions import ActionServer, GoalState, ServerGoal
from homebot.messages.action import ActionType
from homebot.messages.json import message_to_text
from homebot.messages.message import Message

__all__ = ["ProvidedActions"]

_GOAL = "action_goal:"


class _Running:
    """A goal that the client executes."""

    def __init__(self, action_type: ActionType[Any, Any, Any], goal: ServerGoal[Any, Any, Any]) -> None:
        self.action_type = action_type
        self.goal = goal
        self.end: asyncio.Future[tuple[int, Message | None]] = asyncio.get_running_loop().create_future()


class ProvidedActions:
    """The actions that one connection of a client serves, under the names that the client uses.

    One that an older connection of the same client serves passes to the newer one, as a service does. The goals of a
    connection that ends are aborted.

    Args:
        node: The node that serves in the client's stead.
        client: The name of the client.
        limit: Goals that the client may execute at a time; one more is rejected.
        outbox: Takes frames to the client.
        providers: The connection that provides each service and action, by its full name.
        on_taken: Called with the name of an action that a newer connection took over.

    Attributes:
        client: The name of the client.
    """

    def __init__(
        self,
        node: Node,
        client: str,
        limit: int,
        outbox: Outbox,
        providers: dict[str, Provider],
        on_taken: Callable[[str], None],
    ) -> None:
        self._node = node
        self.client = client
        self._limit = limit
        self._outbox = outbox
        self._providers = providers
        self._on_taken = on_taken
        self._servers: dict[str, ActionServer[Any, Any, Any]] = {}
        self._running: dict[str, _Running] = {}
        self._goals = 0

    def __len__(self) -> int:
        return len(self._servers)

    def advertise(self, op: AdvertiseAction) -> None:
        """Offer an action of the client; the same once more is fine.

        Raises:
            InvalidNameError: The name is illegal.
            DuplicateNameError: Another node serves it.
            TypeMismatchError: It is of another type.
            PeerError: The type is unknown.
        """
        name = self._node.resolve_name(op.action, "action name")
        action_type = action_type_of(self._node.graph, name, op.type)
        if op.action in self._servers:
            return
        older = self._providers.get(_key(name))
        if older is not None and older.client == self.client:
            older.hand_over(name)

        async def execute(goal: ServerGoal[Any, Any, Any]) -> Message | None:
            return await self._execute(op.action, action_type, goal)

        self._servers[op.action] = ActionServer(
            self._node, action_type, op.action, execute, on_goal=lambda _: self._has_room(), on_cancel=self._cancel
        )
        self._providers[_key(name)] = self

    def unadvertise(self, op: UnadvertiseAction) -> None:
        """Withdraw an action; its goals are aborted.

        Raises:
            PeerError: The client does not serve it.
        """
        if op.action not in self._servers:
            raise PeerError(f"action {op.action} is not served by this client")
        self._withdraw(op.action)

    def publish_feedback(self, op: ActionFeedback) -> None:
        """Publish feedback of a goal; that of an ended one is ignored.

        Raises:
            TypeMismatchError: The values do not fit the action.
            PeerError: The goal is none of this client's.
        """
        running = self._find(op)
        if running is not None:
            running.goal.publish_feedback(partial_message_from_client(running.action_type.Feedback, op.values)[0])

    def end(self, op: ActionResult) -> None:
        """End a goal; a second result is ignored, which roslib sends after it has advertised twice.

        Raises:
            TypeMismatchError: The values do not fit the action; the goal is aborted.
            PeerError: The goal is none of this client's.
        """
        running = self._find(op)
        if running is None or running.end.done():
            return
        status: int = GoalState.ABORTED
        result: Message | None = None
        try:
            if isinstance(op.values, dict):
                result, _ = partial_message_from_client(running.action_type.Result, op.values)
                status = op.status
        finally:
            running.end.set_result((status, result))

    def hand_over(self, full_name: str) -> None:
        """Withdraw the action of this name, which a newer connection takes over; its goals are aborted."""
        name = next(name for name, server in self._servers.items() if server.action_name == full_name)
        self._withdraw(name)
        self._on_taken(name)

    def close_one(self) -> bool:
        """Withdraw one action and abort its goals; return whether there was one."""
        if not self._servers:
            return False
        self._withdraw(next(reversed(self._servers)))
        return True

    def _withdraw(self, name: str) -> None:
        server = self._servers.pop(name)
        del self._providers[_key(server.action_name)]
        server.close()

    def _has_room(self) -> bool:
        return len(self._running) < self._limit and self._outbox.has_room

    def _cancel(self, goal: ServerGoal[Any, Any, Any]) -> bool:
        for identifier, running in self._running.items():
            if running.goal is goal:
                self._ask_to_cancel(identifier)
        return True  # one whose execution is yet to begin is cancelled then

    def _ask_to_cancel(self, identifier: str) -> None:
        action = identifier.rpartition(":")[0].removeprefix(_GOAL)
        self._outbox.answer(action_cancellation(action, identifier))

    def _find(self, op: ActionFeedback | ActionResult) -> _Running | None:
        identifier = str(op.id)
        prefix, _, number = identifier.rpartition(":")
        is_ours = prefix == f"{_GOAL}{op.action}" and number.isdecimal() and int(number) <= self._goals
        if not is_ours:
            raise PeerError(f"this client executes no goal of {op.action} with the id {op.id!r}")
        return self._running.get(identifier)

    async def _execute(
        self, name: str, action_type: ActionType[Any, Any, Any], goal: ServerGoal[Any, Any, Any]
    ) -> Message | None:
        self._goals += 1
        identifier = f"{_GOAL}{name}:{self._goals}"
        running = self._running[identifier] = _Running(action_type, goal)
        try:
            self._outbox.answer(action_goal(name, action_type.ros_type, identifier, message_to_text(goal.request)))
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
    """Return the key of an action among the providers, where it is no service's."""
    return f"{action}/_action"
