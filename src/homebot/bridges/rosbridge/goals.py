"""The goals of a client: those that it sends, and those that it executes."""

import asyncio
from functools import partial
from typing import Any, NamedTuple

import anyio.lowlevel
from anyio.abc import TaskGroup

from homebot.bridges.rosbridge.client import OutsideClient
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.protocol import (
    ActionFeedback,
    ActionOperation,
    ActionResult,
    AdvertiseAction,
    SendActionGoal,
    failure_frame,
    frame_text,
)
from homebot.bridges.rosbridge.services import cause_of_call, named_values, parse_queries, similar_name
from homebot.bridges.rosbridge.shared_state import Provisions, SharedState
from homebot.bridges.rosbridge.types import action_type_of, request_from_client
from homebot.errors import HomebotError, PeerError
from homebot.graph.actions import ActionClient, ActionServer, ClientGoal, GoalState, ServerGoal
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.messages.json import JsonObject, message_to_text
from homebot.messages.message import Message

_MAX_TURNS = 100
"""Turns for which the result of a goal waits for its feedback."""


class _SentGoal:
    """A goal that was sent, and perhaps accepted."""

    def __init__(self, op: SendActionGoal, client: ActionClient[Any, Any, Any]) -> None:
        self.op = op
        self.key: object = self if op.id is None else op.id
        self.client = client
        self.goal: ClientGoal[Any, Any] | None = None
        self.is_unwanted = False


class SentGoals:
    """The goals of one connection by the client's ids; they are cancelled at its end.

    Each goal is always answered by one result. Feedback is dropped if the client does not read.
    """

    def __init__(self, client: OutsideClient, outbox: Outbox, tasks: TaskGroup) -> None:
        shared = client.shared
        self._node, self._access, self._limit = shared.node, client.access, shared.settings.max_calls
        self._outbox, self._tasks, self._counters = outbox, tasks, shared.counters
        self._goals: dict[object, _SentGoal] = {}
        self._clients: dict[str, ActionClient[Any, Any, Any]] = {}

    def __len__(self) -> int:
        return len(self._goals)

    def __contains__(self, identifier: object) -> bool:
        return identifier in self._goals

    def send(self, op: SendActionGoal) -> None:
        """Send a goal; its result follows later."""
        if op.id is not None and op.id in self._goals:
            raise PeerError(f"a goal with the id {op.id!r} is under way already; its id is not answered twice")
        if len(self._goals) >= self._limit:
            raise PeerError(f"{len(self._goals)} goals of this client are under way already")
        name = self._node.resolve_name(op.action, "action name")
        if self._node.graph.get_action_type(name) is None:
            hint = similar_name(name, [action.name for action in self._node.graph.actions()], "/rosapi/action_servers")
            raise PeerError(f"action {name} has no server now; {hint}")
        action_type = action_type_of(self._node.graph, name, op.action_type)
        values, problem = parse_queries(action_type.Goal, named_values(action_type.Goal, op.args))
        if problem is not None:
            raise problem
        request = request_from_client(
            action_type.Goal, self._access.stamped(action_type.Goal, values), self._node.graph.clock.now()
        )
        if name not in self._clients:
            self._clients[name] = ActionClient(self._node, action_type, name)
        sent = _SentGoal(op, self._clients[name])
        self._goals[sent.key] = sent
        self._tasks.start_soon(self._run, sent, request)

    def cancel(self, op: ActionOperation) -> None:
        """Cancel a goal, at once or when it is accepted; its result tells how it ended."""
        sent = self._goals.get(op.id)
        if sent is None:
            raise PeerError(f"no goal of {op.action} with the id {op.id!r} is under way")
        sent.is_unwanted = True
        if sent.goal is not None:
            sent.goal.request_cancel()

    def close_one(self) -> bool:
        """Cancel the goals of one action; return whether there was one."""
        if not self._clients:
            return False
        self._clients.popitem()[1].close()
        return True

    async def _run(self, sent: _SentGoal, request: Message) -> None:
        op, client, status = sent.op, sent.client, GoalState.UNKNOWN
        CURRENT_CAUSE.set(cause_of_call(self._node, self._access, client.action_name))
        try:
            sent.goal = await client.send_goal(request, partial(self._forward, sent) if op.feedback else None)
            status = GoalState.ABORTED
            if sent.is_unwanted:
                sent.goal.request_cancel()
            state, result = await sent.goal.result()
            for _ in range(_MAX_TURNS):
                if not client.has_feedback:
                    break
                await anyio.lowlevel.checkpoint()  # feedback is sent before the result
            fields: JsonObject = {"action": op.action, "status": int(state), "result": True}
            frame = frame_text("action_result", op.id, fields, values=message_to_text(result))
        except HomebotError as exc:
            frame = failure_frame(op, str(exc), int(status))
        finally:
            self._goals.pop(sent.key, None)
            if not any(goal.client is client for goal in self._goals.values()):
                self._clients.pop(client.action_name, None)
                client.close()
        self._outbox.answer(frame)

    def _forward(self, sent: _SentGoal, feedback: Message) -> None:
        op = sent.op
        if self._goals.get(sent.key) is not sent:
            return
        if self._outbox.has_room:
            frame = frame_text("action_feedback", op.id, {"action": op.action}, values=message_to_text(feedback))
            self._outbox.answer(frame)
        else:
            self._counters.feedback_lost += 1


_GOAL = "action_goal:"


class _Running(NamedTuple):
    goal: ServerGoal[Any, Any, Any]
    end: asyncio.Future[tuple[int, Message | None]]


class ProvidedActions:
    """The actions served by one connection of a client; their goals are aborted at its end."""

    def __init__(self, shared: SharedState, outbox: Outbox, provisions: Provisions) -> None:
        self._node, self._limit = shared.node, shared.settings.max_calls
        self._outbox, self._provisions = outbox, provisions
        self._running: dict[str, _Running] = {}
        self._goals = 0

    def advertise(self, op: AdvertiseAction) -> None:
        """Offer an action of the client. Idempotent."""
        name = self._node.resolve_name(op.action, "action name")
        action_type = action_type_of(self._node.graph, name, op.type)
        create = partial(ActionServer[Any, Any, Any], on_goal=self._has_room, on_cancel=self._cancel)
        execute = partial(self._execute, op.action, op.type)
        self._provisions.add(_key(name), lambda: create(self._node, action_type, name, execute))

    def unadvertise(self, op: ActionOperation) -> None:
        """Withdraw an action; its goals are aborted."""
        if not self._provisions.remove(_key(self._node.resolve_name(op.action, "action name"))):
            raise PeerError(f"action {op.action} is not served by this client")

    def publish_feedback(self, op: ActionFeedback) -> None:
        """Publish feedback of a goal, unless it has ended."""
        running = self._find(op)
        if running is not None:
            feedback_type = running.goal.action_type.Feedback
            running.goal.publish_feedback(self._read(feedback_type, op.values))

    def end(self, op: ActionResult) -> None:
        """End a goal; a second result is ignored, as roslib sends one after advertising twice.

        Raises:
            TypeMismatchError: The values do not fit the action; the goal is aborted.
            PeerError: The goal does not belong to this client.
        """
        running = self._find(op)
        if running is None or running.end.done():
            return
        end: tuple[int, Message | None] = (GoalState.ABORTED, None)
        try:
            if isinstance(op.values, dict | list):
                result_type = running.goal.action_type.Result
                status = op.status or (GoalState.SUCCEEDED if op.result else GoalState.ABORTED)
                end = status, self._read(result_type, named_values(result_type, op.values))
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
        return True  # a goal that has not started is cancelled when it does

    def _ask_to_cancel(self, identifier: str) -> None:
        action = identifier.rpartition(":")[0].removeprefix(_GOAL)
        self._outbox.answer(frame_text("cancel_action_goal", identifier, {"action": action}))

    def _find(self, op: ActionFeedback | ActionResult) -> _Running | None:
        """Return the goal of *op*; None if it has ended."""
        prefix, _, number = str(op.id).rpartition(":")
        if prefix != f"{_GOAL}{op.action}" or not number.isdecimal() or int(number) > self._goals:
            raise PeerError(f"this client executes no goal of {op.action} with the id {op.id!r}")
        return self._running.get(str(op.id))

    async def _execute(self, name: str, ros_type: str, goal: ServerGoal[Any, Any, Any]) -> Message | None:
        self._goals += 1
        identifier = f"{_GOAL}{name}:{self._goals}"
        running = self._running[identifier] = _Running(goal, asyncio.get_running_loop().create_future())
        try:
            fields: JsonObject = {"action": name, "action_type": ros_type, "feedback": True}
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
    """Return the key of an action among the servers, different from any service's."""
    return f"{action}/_action"
