"""One client of the door: its rights and its entities, which end with it.

Frames are handled in the order in which they come, each in a turn of its own; service calls run side by side.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress
from functools import partial
from typing import Any, NamedTuple

import anyio
from anyio.abc import TaskGroup

from homebot.bridges.rosbridge import protocol
from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
from homebot.bridges.rosbridge.heartbeat import Heartbeat
from homebot.bridges.rosbridge.holdings import Holdings
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.packing import FrameAssembler, Packing
from homebot.bridges.rosbridge.refusals import operation_text
from homebot.bridges.rosbridge.services import call_service, missing_service
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.devices.client_rights import ClientRights, Right
from homebot.errors import HomebotError, LinkError, PeerError
from homebot.graph import Client
from homebot.log import LogLimit
from homebot.messages.message import Message
from homebot.support.rate_limit import RateLimit

__all__ = ["ClientSession", "DoorLink"]

_SEVERITY: dict[protocol.Level, int] = {"none": 0, "error": 1, "warning": 2, "info": 3}
_OPENING = (protocol.Advertise, protocol.AdvertiseAction, protocol.AdvertiseService, protocol.SubscribeOperation)
_PACKED = (protocol.Request, protocol.SubscribeOperation)
_ANSWERS = 1_048_576
"""Bytes of answers that may wait for a client before it is not read from any more."""


class DoorLink(NamedTuple):
    """A connection to a client.

    Attributes:
        send: Takes a frame to the client, waiting until there is room for it; LinkError when the client is gone.
        ping: Returns when the client has answered a ping.
        is_excused: Returns whether the client was heard since the last call, or is not being read from.
    """

    send: Callable[[str | bytes], Awaitable[None]]
    cut: Callable[[], None]
    ping: Callable[[], Awaitable[None]]
    is_excused: Callable[[], bool]


class ClientSession:
    """All that one client does through the door.

    Args:
        name: The name of its token, see :class:`ClientAccess`.
        is_page: Whether the client is homebot's own page without a token.
        is_roslibpy: Whether the client is roslibpy. It receives JSON where it asks for PNG, and no ``status`` frames
            unless it asks for them with ``set_level``: it raises an exception for each.

    Attributes:
        refused: Frames and requests of the client that were refused.
    """

    def __init__(
        self,
        shared: SharedState,
        name: str,
        rights: ClientRights,
        client: str,
        link: DoorLink,
        *,
        is_page: bool,
        is_roslibpy: bool,
    ) -> None:
        self.refused = 0
        self._reads_png = not is_roslibpy
        self._shared = shared
        self._access = ClientAccess.of(name, rights, shared.owners(), is_page=is_page)
        self._node, self._turns = shared.node, shared.turns
        self._settings = settings = shared.settings
        self._client = client
        self._link = link
        self._outbox = Outbox(link.send, link.cut, shared.turns, _ANSWERS)
        self._heartbeat = Heartbeat(link.ping, settings.ping_interval, settings.ping_timeout, link.is_excused)
        self._assembler = FrameAssembler(settings.max_frame_bytes)
        self._level: protocol.Level = "none" if is_roslibpy else "error"
        self._calls = 0
        self._slowness = LogLimit(shared.node.graph.clock)

    async def run(self, frames: AsyncIterator[str]) -> None:
        """Carry out *frames* until they end; then release everything the client holds."""
        async with anyio.create_task_group() as tasks:
            holdings = Holdings(self._shared, self._access, self._outbox, tasks, self._report_unfit, self._report_taken)
            try:
                tasks.start_soon(self._send, tasks)
                tasks.start_soon(self._watch, holdings, tasks)
                await self._read(frames, holdings, tasks)
            finally:
                tasks.cancel_scope.cancel()
                with anyio.CancelScope(shield=True):
                    await holdings.close()

    async def _send(self, tasks: TaskGroup) -> None:
        with suppress(LinkError):  # the client is gone, and so is the session
            await self._outbox.run()
        tasks.cancel_scope.cancel()

    async def _watch(self, holdings: Holdings, tasks: TaskGroup) -> None:
        """End the session when the client vanishes while something of it runs."""
        await self._heartbeat.run(lambda: holdings.must_end)
        self._shared.counters.clients_vanished += 1
        self._log("vanished", "door.client_vanished", " answers no ping: its goals and leases end")
        self._link.cut()
        tasks.cancel_scope.cancel()

    async def _read(self, frames: AsyncIterator[str], holdings: Holdings, tasks: TaskGroup) -> None:
        """Handle one frame after the other, no faster than the client may send and takes its answers."""
        now = self._node.graph.clock.monotonic
        most = self._settings.max_frames_per_second
        rate = RateLimit(most, at_once=most)
        async for frame in frames:
            if wait := rate.charge(now()):
                self._report_slow()
                await anyio.sleep(wait)
            await self._outbox.room()
            await self._turns.turn()
            await self._handle(frame, holdings, tasks)

    async def _handle(self, frame: str, holdings: Holdings, tasks: TaskGroup) -> None:
        self._shared.counters.frames += 1
        if holdings.publications.keep_unread(frame):
            return
        try:
            op = await self._turns.run(self._assembler.read(frame))
        except protocol.FrameError as exc:
            refusal = _refusal(exc.op, exc.name, exc.problem)
            self._log_error(
                f": {refusal}" if exc.op else f" sent a frame that {exc.problem}", exc.op or "frame", exc.problem
            )
            self._answer(exc, str(exc))
            return
        if op is None:
            self._shared.counters.fragments_dropped += self._assembler.dropped
            self._assembler.dropped = 0
            return
        try:
            self._check(op)
            self._do(op, holdings, tasks, len(frame))
        except MissingRightError as exc:
            self.refused += 1
            self._shared.record_refusal(self._access, self._client, op, exc)
            self._answer(op, str(exc))
        except HomebotError as exc:
            self._log_error(f": {_refusal(op.op, op.name, str(exc))}", op.op, str(exc))
            self._answer(op, str(exc))

    def _check(self, op: protocol.Operation) -> None:
        """Refuse *op* where the client has no right to it.

        Raises:
            PeerError: The right is missing; or the service does not exist, which a client that may list all is told.
            InvalidNameError: The name is illegal.
        """
        try:
            self._access.check(op, self._node.resolve_name)
        except MissingRightError:
            may_list = self._access.rights.has(Right.READ)
            if may_list and isinstance(op, protocol.CallService) and (problem := missing_service(self._node, op)):
                raise PeerError(problem) from None
            raise

    def _do(self, op: protocol.Operation, holdings: Holdings, tasks: TaskGroup, size: int) -> None:
        if isinstance(op, _OPENING):
            self._check_room(holdings)
        if isinstance(op, _PACKED) and op.compression == "png" and not self._reads_png:
            op = op.model_copy(update={"compression": "none"})
        match op:
            case protocol.PublishOperation():
                self._publish(op, holdings, size)
            case protocol.SubscribeOperation():
                self._subscribe(op, holdings)
            case protocol.CallService():
                self._start_call(op, holdings, tasks)
            case protocol.SetLevel():
                self._level = op.level
            case _:
                holdings.handle(op)
                if isinstance(op, protocol.SendActionGoal):
                    self._watch_over(holdings)

    def _publish(self, op: protocol.PublishOperation, holdings: Holdings, size: int) -> None:
        if op.topic not in holdings.publications:
            self._check_room(holdings)
        if missing := holdings.publications.publish(op, size):
            text = f"the message on {op.topic} lacks {', '.join(missing)}, which were taken for zero or empty"
            self._remark("warning", text, op.id)

    def _subscribe(self, op: protocol.SubscribeOperation, holdings: Holdings) -> None:
        if (remark := holdings.subscriptions.subscribe(op)) is not None:
            self._remark(*remark, op.id)

    def _start_call(self, op: protocol.CallService, holdings: Holdings, tasks: TaskGroup) -> None:
        if self._calls >= self._settings.max_calls:
            raise PeerError(f"{self._calls} calls of this client are waiting already")
        self._calls += 1
        tasks.start_soon(self._call, op, holdings)

    async def _call(self, op: protocol.CallService, holdings: Holdings) -> None:
        try:
            await self._outbox.room()
            await self._turns.turn()
            answer = partial(self._outbox.answer, packing=Packing.of(op))
            await call_service(self._node, op, self._turns, self._access, answer, partial(self._on_request, holdings))
        finally:
            self._calls -= 1

    def _on_request(self, holdings: Holdings, client: Client[Any, Any], request: Message) -> None:
        self._shared.leases.record(holdings, client, request)
        self._watch_over(holdings)

    def _watch_over(self, holdings: Holdings) -> None:
        if holdings.must_end:
            self._heartbeat.start()

    def _check_room(self, holdings: Holdings) -> None:
        if len(holdings) >= self._settings.max_entities:
            raise PeerError(f"this client uses {len(holdings)} topics and services already, the limit")
        if (held := self._shared.held_by_all()) >= self._settings.max_entities_of_all:
            raise PeerError(f"all clients together use {held} topics and services already, the limit")

    def _report_slow(self) -> None:
        self._shared.counters.slowed_down += 1
        if self._slowness.allows("") is not None:
            limit = f"more than {self._settings.max_frames_per_second} frames a second"
            self._remark("warning", f"{limit} came from this client: it is being throttled to that rate", None)
            self._log("slowed down", "door.slowed_down", f" sends {limit}: it is being throttled to that rate")

    def _report_taken(self, name: str) -> None:
        service = name.removesuffix("/_action")
        problem = f"{service} is provided by a newer connection of the client {self._access.name} now"
        self._log("taken over", "door.service_taken_over", f": {problem}", service=service)
        self._remark("error", problem, None)

    def _report_unfit(self, op: str, topic: str, problem: str, identifier: protocol.Identifier = None) -> None:
        """Report that *op* is refused after all: the topic it waited for is of another type, or its message unfit."""
        error_text = f": {_refusal(op, topic, problem)}, now that it is used"
        self._log_error(error_text, op, problem, event="door.late_topic_unfit")
        self._remark("error", problem, identifier)

    def _log_error(self, error_text: str, op: str, problem: str, *, event: str = "door.refused") -> None:
        self.refused += 1
        self._shared.counters.requests_refused += 1
        self._log("refused", event, error_text, op=op, problem=problem, refused=self.refused)

    def _log(self, kind: str, event: str, text: str, **facts: str | int) -> None:
        """Log *text*, which follows the name of the client; lines of one *kind* and address are limited."""
        host = self._client.rpartition(":")[0]
        log, client = self._shared.error_log.log, self._client
        log(f"{kind} {host}", event, f"{client}{text}", level="warning", error=None, client=client, **facts)

    def _answer(self, op: protocol.Operation | protocol.FrameError, problem: str) -> None:
        if op.op in {"call_service", "send_action_goal"}:
            self._outbox.answer(protocol.failure_frame(op, problem))
        else:
            self._remark("warning" if op.op == "unadvertise" else "error", problem, op.id)

    def _remark(self, level: protocol.Level, text: str, identifier: protocol.Identifier) -> None:
        """Send the client a remark, if it asked for those of this *level*."""
        if _SEVERITY[self._level] >= _SEVERITY[level]:
            self._outbox.answer(protocol.frame_text("status", identifier, {"level": level, "msg": text}))


def _refusal(op: str, name: str, problem: str) -> str:
    return f"{operation_text(op, name)} was refused: {problem}"
