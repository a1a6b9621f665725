"""One connection of a client: its operations, and its entities, which end with it.

Frames are handled in order, each in a separate turn; service calls run concurrently.
"""

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any, NamedTuple

import anyio
from anyio.abc import TaskGroup

from homebot.bridges.rosbridge import protocol
from homebot.bridges.rosbridge.access import MissingRightError
from homebot.bridges.rosbridge.backlog import Backlog
from homebot.bridges.rosbridge.client import OutsideClient, operation_text
from homebot.bridges.rosbridge.heartbeat import Heartbeat
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.publications import Publications
from homebot.bridges.rosbridge.services import CallDelays, ProvidedServices, call_service, missing_service
from homebot.bridges.rosbridge.shared_state import Provisions
from homebot.bridges.rosbridge.subscriptions import Subscriptions
from homebot.errors import HomebotError, LinkError, PeerError
from homebot.graph import Client
from homebot.log import LogLimit
from homebot.messages.message import Message
from homebot.rights import Right
from homebot.support.limits import RateLimit

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.goals import SentGoals

_SEVERITY: dict[protocol.Level, int] = {"none": 0, "error": 1, "warning": 2, "info": 3}
_OPENING = frozenset({"advertise", "advertise_action", "advertise_service", "subscribe"})
_ANSWERS = 1_048_576
"""Bytes of waiting answers from which a client is not read from."""


class SessionLink(NamedTuple):
    """A connection to a client.

    Attributes:
        send: Sends a frame, waiting for room; raises LinkError if the client is gone.
        ping: Returns when the client has answered a ping.
        is_excused: Returns whether the client has been heard since the last call, or is not being read from.
    """

    send: Callable[[str | bytes], Awaitable[None]]
    cut: Callable[[], None]
    ping: Callable[[], Awaitable[None]]
    is_excused: Callable[[], bool]


class ClientSession:
    """The session of one client of the rosbridge server: its topics, services, actions, goals and leases.

    Args:
        is_roslibpy: Whether the client is roslibpy, which gets no ``status`` frames unless it asks for them with
            ``set_level``, as it raises an exception for each.
    """

    def __init__(self, client: OutsideClient, link: SessionLink, *, is_roslibpy: bool) -> None:
        self.client, self._link = client, link
        self._shared = shared = client.shared
        self._node, self._turns = shared.node, shared.turns
        self._settings = settings = shared.settings
        self._outbox = Outbox(link.send, link.cut, shared.turns, _ANSWERS)
        self._heartbeat = Heartbeat(link.ping, settings.ping_interval, settings.ping_timeout, link.is_excused)
        self._level: protocol.Level = "none" if is_roslibpy else "error"
        self._calls, self._delays = 0, CallDelays()
        self._slowness = LogLimit(shared.node.graph.clock)
        self._tasks: TaskGroup = anyio.create_task_group()
        self._backlog = Backlog(settings.max_waiting_bytes, shared.backlog)
        self._publications = Publications(client, self._report_unfit)
        self._subscriptions = Subscriptions(client, self._backlog, self._outbox, self._report_unfit)
        self._provisions = Provisions(client.access.name, shared.providers, self._report_taken)
        self._services = services = ProvidedServices(shared, self._outbox, self._provisions)
        self._goals: SentGoals | None = None
        # Each raises a HomebotError to refuse its operation, which is reported to the client.
        self._handlers: dict[str, Callable[[Any], object]] = {
            "advertise": self._publications.advertise,
            "unadvertise": self._publications.unadvertise,
            "subscribe": self._subscribe,
            "unsubscribe": self._subscriptions.unsubscribe,
            "call_service": self._start_call,
            "advertise_service": services.advertise,
            "unadvertise_service": services.unadvertise,
            "service_response": services.answer,
            "set_level": self._set_level,
        }

    async def run(self, frames: AsyncIterator[str]) -> None:
        """Handle *frames* until they end, then release everything that the client holds."""
        async with self._tasks as tasks:
            try:
                tasks.start_soon(self._send)
                tasks.start_soon(self._watch)
                await self._read(frames)
            finally:
                tasks.cancel_scope.cancel()
                with anyio.CancelScope(shield=True):
                    self._backlog.close()
                    for kind in (self._goals, self._provisions, self._publications, self._subscriptions):
                        while kind is not None and kind.close_one():
                            await self._turns.turn()
                    self._shared.leases.release(self)

    async def _send(self) -> None:
        with suppress(LinkError):  # the client is gone, and so is the session
            await self._outbox.run()
        self._tasks.cancel_scope.cancel()

    def _must_end(self) -> bool:
        """Return whether the client has a goal or a lease, which must end soon after it."""
        return bool(self._goals) or self._shared.leases.has(self)

    async def _watch(self) -> None:
        """End the session if the client vanishes while it has a goal or a lease."""
        await self._heartbeat.run(self._must_end)
        self._shared.counters.clients_vanished += 1
        self.client.log("vanished", "door.client_vanished", " answers no ping: its goals and leases end")
        self._link.cut()
        self._tasks.cancel_scope.cancel()

    async def _read(self, frames: AsyncIterator[str]) -> None:
        """Handle the frames one by one, limited by the client's rate and its reading of answers."""
        now = self._node.graph.clock.monotonic
        most = self._settings.max_frames_per_second
        rate = RateLimit(most, at_once=most)
        async for frame in frames:
            if wait := rate.charge(now()):
                self._shared.counters.slowed_down += 1
                if self._slowness.allows("") is not None:
                    limit = f"more than {self._settings.max_frames_per_second} frames a second"
                    self._remark("warning", f"{limit} came from this client: it is being throttled to that rate", None)
                    self.client.log(
                        "slowed down", "door.slowed_down", f" sends {limit}: it is being throttled to that rate"
                    )
                await anyio.sleep(wait)
            await self._outbox.room()
            await self._turns.turn()
            await self._handle(frame)

    async def _handle(self, frame: str) -> None:
        self._shared.counters.frames += 1
        if self._publications.store_unread(frame) or self._is_refused_again(frame):
            return
        try:
            op = await self._turns.run(protocol.parse_frame(frame))
        except protocol.FrameError as exc:
            text = f": {_refusal(exc.op, exc.name, exc.problem)}" if exc.op else f" sent a frame that {exc.problem}"
            self.client.log_refusal(text, exc.op or "frame", exc.problem)
            self._answer(exc, str(exc))
            return
        try:
            self._check(op)
            if isinstance(op, protocol.SendActionGoal):
                await self._node.graph.begin(self._node.resolve_name(op.action, "action name"))
            self._do(op, len(frame))
        except MissingRightError as exc:
            self._refuse(op, exc)
        except HomebotError as exc:
            self.client.log_refusal(f": {_refusal(op.op, op.name, str(exc))}", op.op, str(exc))
            self._answer(op, str(exc))

    def _is_refused_again(self, frame: str) -> bool:
        """Return whether *frame* is a message on a topic that is refused as before; then it need not be parsed."""
        op = self._publications.refused_before(frame)
        if op is None:
            return False
        try:
            self._check(op)
        except MissingRightError as exc:
            self._refuse(op, exc)
            return True
        return False

    def _refuse(self, op: protocol.Operation, error: MissingRightError) -> None:
        if isinstance(op, protocol.PublishOperation):
            self._publications.record_refused(op.topic)
        self.client.record_missing_right(op, error)
        self._answer(op, str(error))

    def _check(self, op: protocol.Operation) -> None:
        access = self.client.access
        try:
            access.check(op, self._node.resolve_name)
        except MissingRightError:
            may_list = access.rights.has(Right.READ)
            if may_list and isinstance(op, protocol.CallService) and (problem := missing_service(self._node, op)):
                raise PeerError(problem) from None
            raise

    def _do(self, op: protocol.Operation, size: int) -> None:
        if op.op in _OPENING:
            self._check_room()
        if (asked := getattr(op, "compression", "none")) not in protocol.COMPRESSIONS:
            known = ", ".join(protocol.COMPRESSIONS)
            self._remark("error", f"there is no compression {asked[:60]!r}, so JSON comes; there are {known}", op.id)
        if isinstance(op, protocol.ActionOperation) and self._goals is None:
            from homebot.bridges.rosbridge.goals import ProvidedActions, SentGoals  # noqa: PLC0415 - with the first one

            self._goals = goals = SentGoals(self.client, self._outbox, self._tasks)
            provided = ProvidedActions(self._shared, self._outbox, self._provisions)
            self._handlers |= {
                "send_action_goal": goals.send,
                "cancel_action_goal": goals.cancel,
                "advertise_action": provided.advertise,
                "unadvertise_action": provided.unadvertise,
                "action_feedback": provided.publish_feedback,
                "action_result": provided.end,
            }
        if isinstance(op, protocol.PublishOperation):
            if op.topic not in self._publications:
                self._check_room()
            if missing := self._publications.publish(op, size):
                text = f"the message on {op.topic} lacks {', '.join(missing)}, which were taken for zero or empty"
                self._remark("warning", text, op.id)
        elif (handle := self._handlers.get(op.op)) is not None:
            handle(op)
        if isinstance(op, protocol.SendActionGoal):
            self._watch_over()

    def _subscribe(self, op: protocol.SubscribeOperation) -> None:
        if (remark := self._subscriptions.subscribe(op)) is not None:
            self._remark(*remark, op.id)

    def _set_level(self, op: protocol.SetLevel) -> None:
        self._level = op.level

    def _start_call(self, op: protocol.CallService) -> None:
        if op.sent:
            self._delays.check(op, anyio.current_time())
        if self._calls >= self._settings.max_calls:
            raise PeerError(f"{self._calls} calls of this client are waiting already")
        self._calls += 1
        self._tasks.start_soon(self._call, op)

    async def _call(self, op: protocol.CallService) -> None:
        try:
            await self._outbox.room()
            await self._turns.turn()
            await call_service(self._node, op, self._turns, self.client.access, self._outbox.answer, self._on_request)
        finally:
            self._calls -= 1

    def _on_request(self, client: Client[Any, Any], request: Message) -> None:
        self._shared.leases.record(self, client, request)
        self._watch_over()

    def _watch_over(self) -> None:
        if self._must_end():
            self._heartbeat.start()

    def _check_room(self) -> None:
        held = len(self._publications) + len(self._subscriptions) + len(self._provisions)
        if held >= self._settings.max_entities:
            raise PeerError(f"this client uses {held} topics and services already, the limit")
        held = self._node.graph.count_endpoints(self._node.full_name)
        if held >= self._settings.max_entities_of_all:
            raise PeerError(f"all clients together use {held} topics and services already, the limit")

    def _report_taken(self, name: str) -> None:
        """Report that a newer connection took over the service or action *name*."""
        service = name.removesuffix("/_action")
        problem = f"{service} is provided by a newer connection of the client {self.client.access.name} now"
        self.client.log("taken over", "door.service_taken_over", f": {problem}", service=service)
        self._remark("error", problem, None)

    def _report_unfit(self, op: str, topic: str, problem: str, identifier: protocol.Identifier) -> None:
        """Report that *op* is refused after all: its topic has another type, or its message is invalid."""
        text = f": {_refusal(op, topic, problem)}, now that it is used"
        self.client.log_refusal(text, op, problem, "door.late_topic_unfit")
        self._remark("error", problem, identifier)

    def _answer(self, op: protocol.Operation | protocol.FrameError, problem: str) -> None:
        is_new_goal = op.op == "send_action_goal" and op.id not in (self._goals or ())
        if op.op == "call_service" or is_new_goal:
            self._outbox.answer(protocol.failure_frame(op, problem))
        else:
            self._remark("warning" if op.op == "unadvertise" else "error", problem, op.id)

    def _remark(self, level: protocol.Level, text: str, identifier: protocol.Identifier) -> None:
        """Send the client a remark, if it wants those of this *level*."""
        if _SEVERITY[self._level] >= _SEVERITY[level]:
            self._outbox.answer(protocol.frame_text("status", identifier, {"level": level, "msg": text}))


def _refusal(op: str, name: str, problem: str) -> str:
    return f"{operation_text(op, name)} was refused: {problem}"
