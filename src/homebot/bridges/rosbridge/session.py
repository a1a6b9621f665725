"""One client of the door: its rights and its entities, which end with it.

Frames are handled in the order in which they come, each in a turn of its own; service calls run side by side.
"""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, NamedTuple, Protocol

import anyio
from anyio.abc import TaskGroup

from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
from homebot.bridges.rosbridge.backlog import Backlog
from homebot.bridges.rosbridge.frame_assembler import FrameAssembler
from homebot.bridges.rosbridge.heartbeat import Heartbeat, OwnedLeases
from homebot.bridges.rosbridge.outbox import Outbox
from homebot.bridges.rosbridge.packing import Packing
from homebot.bridges.rosbridge.protocol import (
    ActionOperation,
    Advertise,
    AdvertiseAction,
    AdvertiseService,
    CallService,
    FrameError,
    Identifier,
    Level,
    Operation,
    PublishOperation,
    ServiceResponse,
    SetLevel,
    SubscribeOperation,
    Unadvertise,
    UnadvertiseService,
    UnsubscribeOperation,
    action_failure,
    service_failure,
    status_frame,
)
from homebot.bridges.rosbridge.provided_services import ProvidedServices
from homebot.bridges.rosbridge.publications import Publications
from homebot.bridges.rosbridge.refusals import operation_text
from homebot.bridges.rosbridge.services import call_service, missing_service
from homebot.bridges.rosbridge.shared_state import SharedState
from homebot.bridges.rosbridge.subscriptions import Subscriptions
from homebot.bridges.turns import ServerTurns
from homebot.devices.client_rights import ClientRights, Right
from homebot.errors import HomebotError, LinkError, PeerError
from homebot.log import LogLimit
from homebot.messages.message import Message
from homebot.support.rate_limit import RateLimit

if TYPE_CHECKING:
    from homebot.bridges.rosbridge.actions import ClientActions

__all__ = ["ClientSession", "DoorLink"]

_SEVERITY: dict[Level, int] = {"none": 0, "error": 1, "warning": 2, "info": 3}
_ANSWERS = 1_048_576
"""Bytes of answers that may wait for a client before it is not read from any more."""


class DoorLink(NamedTuple):
    """A connection to a client.

    Attributes:
        send: Takes a frame to the client, waiting until there is room for it; LinkError when the client is gone.
        cut: Ends the connection at once.
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
        shared: State shared with other clients.
        name: The name of its token, see :class:`ClientAccess`.
        rights: The rights of that token.
        page: The origin of a web page that no token and no configuration vouches for; empty for other clients.
        client: Name of the client in the log.
        link: The connection.
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
        page: str,
        client: str,
        link: DoorLink,
        *,
        is_roslibpy: bool,
    ) -> None:
        self.refused = 0
        self._reads_png = not is_roslibpy
        self._shared = shared
        owners = shared.owners()
        self._access = ClientAccess.of_page(page, name, rights, owners) if page else ClientAccess(name, rights, owners)
        self._node = shared.node
        self._settings = shared.settings
        self._turns = shared.turns
        self._client = client
        self._link = link
        self._outbox = Outbox(link.send, link.cut, shared.turns, _ANSWERS)
        self._leases = OwnedLeases(shared.node.graph.clock)
        settings = shared.settings
        self._heartbeat = Heartbeat(link.ping, settings.ping_interval, settings.ping_timeout, link.is_excused)
        self._assembler = FrameAssembler(shared.settings.max_frame_bytes)
        self._level: Level = "none" if is_roslibpy else "error"
        self._calls = 0
        self._slowness = LogLimit(shared.node.graph.clock)

    async def run(self, frames: AsyncIterator[str]) -> None:
        """Carry out *frames* until they end; then release everything the client holds."""
        backlog = Backlog(self._settings.max_waiting_bytes, self._shared.backlog)
        node, settings = self._node, self._settings
        async with anyio.create_task_group() as tasks:
            holdings = _Holdings(
                Publications(node, self._access, self._report_unfit),
                Subscriptions(
                    node, settings.queue_depth, backlog, self._outbox, self._shared.expected, self._report_unfit
                ),
                ProvidedServices(
                    node,
                    self._access.name,
                    settings.max_calls,
                    self._outbox,
                    self._shared.providers,
                    self._report_taken,
                ),
                tasks,
            )
            try:
                tasks.start_soon(self._send, tasks)
                tasks.start_soon(self._watch, holdings)
                await self._read(frames, holdings)
            finally:
                backlog.close()
                tasks.cancel_scope.cancel()
                with anyio.CancelScope(shield=True):
                    await holdings.close(self._turns)

    async def _send(self, tasks: TaskGroup) -> None:
        with suppress(LinkError):  # the client is gone, and so is the session
            await self._outbox.run()
        tasks.cancel_scope.cancel()

    async def _watch(self, holdings: _Holdings) -> None:
        """End the session when the client vanishes while something of it runs."""
        await self._heartbeat.run(lambda: bool(holdings.goals or self._leases))
        self._shared.counters.clients_vanished += 1
        self._shared.error_log.log(
            f"vanished {self._client.rpartition(':')[0]}",
            "door.client_vanished",
            f"{self._client} answers no ping: its goals and leases end",
            client=self._client,
        )
        self._link.cut()
        holdings.tasks.cancel_scope.cancel()

    async def _read(self, frames: AsyncIterator[str], holdings: _Holdings) -> None:
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
            await self._handle(frame, holdings)

    async def _handle(self, frame: str, holdings: _Holdings) -> None:
        self._shared.counters.frames += 1
        if holdings.publications.keep_unread(frame):
            return
        try:
            op = await self._turns.run(self._assembler.read(frame))
        except FrameError as exc:
            error_text = (
                f": {_refusal(exc.op, exc.target, exc.problem)}" if exc.op else f" sent a frame that {exc.problem}"
            )
            self._log_error(error_text, exc.op or "frame", exc.problem)
            self._answer(exc.op, exc.id, exc.target, str(exc))
            return
        if op is None:
            self._shared.counters.fragments_dropped += self._assembler.dropped
            self._assembler.dropped = 0
            return
        try:
            self._check(op)
            self._do(op, holdings, len(frame))
        except MissingRightError as exc:
            self.refused += 1
            self._shared.counters.requests_refused += 1
            self._shared.counters.rights_missing += 1
            self._shared.refusals.record(self._access, self._client, op, exc)
            self._answer(op.op, op.id, op.name, str(exc))
        except HomebotError as exc:
            self._log_error(f": {_refusal(op.op, op.name, str(exc))}", op.op, str(exc))
            self._answer(op.op, op.id, op.name, str(exc))

    def _check(self, op: Operation) -> None:
        """Refuse *op* where the client has no right to it.

        Raises:
            PeerError: The right is missing; or the service does not exist, which a client that may list all is told.
            InvalidNameError: The name is illegal.
        """
        try:
            self._access.check(op, self._node.resolve_name)
        except MissingRightError:
            may_list = self._access.rights.has(Right.READ)
            if may_list and isinstance(op, CallService) and (problem := missing_service(self._node, op)):
                raise PeerError(problem) from None
            raise

    def _do(self, op: Operation, holdings: _Holdings, size: int) -> None:
        match op:
            case PublishOperation():
                if op.topic not in holdings.publications:
                    self._check_room(holdings)
                if missing := holdings.publications.publish(op, size):
                    text = f"the message on {op.topic} lacks {', '.join(missing)}, which were taken for zero or empty"
                    self._remark("warning", text, op.id)
            case CallService():
                self._start_call(op, holdings.tasks)
            case ServiceResponse():
                holdings.services.answer(op)
            case SetLevel():
                self._level = op.level
            case ActionOperation():
                self._act(op, holdings)
            case _:
                self._register(op, holdings)

    def _register(self, op: Operation, holdings: _Holdings) -> None:
        match op:
            case Advertise():
                self._check_room(holdings)
                holdings.publications.advertise(op)
            case Unadvertise():
                holdings.publications.unadvertise(op)
            case SubscribeOperation():
                self._check_room(holdings)
                self._subscribe(op, holdings)
            case UnsubscribeOperation():
                holdings.subscriptions.unsubscribe(op)
            case AdvertiseService():
                self._check_room(holdings)
                holdings.services.advertise(op)
            case UnadvertiseService():
                holdings.services.unadvertise(op)

    def _act(self, op: ActionOperation, holdings: _Holdings) -> None:
        if isinstance(op, AdvertiseAction):
            self._check_room(holdings)
        if holdings.actions is None:
            from homebot.bridges.rosbridge.actions import ClientActions  # noqa: PLC0415 - loaded with the first one

            holdings.actions = ClientActions(
                self._shared, self._access, self._outbox, holdings.tasks, self._report_taken
            )
        holdings.actions.handle(op)
        if holdings.goals:
            self._heartbeat.start()

    def _subscribe(self, op: SubscribeOperation, holdings: _Holdings) -> None:
        if op.compression == "png" and not self._reads_png:
            op = op.model_copy(update={"compression": "none"})
        if (remark := holdings.subscriptions.subscribe(op)) is not None:
            self._remark(*remark, op.id)

    def _start_call(self, op: CallService, tasks: TaskGroup) -> None:
        if self._calls >= self._settings.max_calls:
            raise PeerError(f"{self._calls} calls of this client are waiting already")
        self._calls += 1
        tasks.start_soon(partial(self._call, op))

    async def _call(self, op: CallService) -> None:
        try:
            await self._outbox.room()
            await self._turns.turn()
            packing = Packing(self._reads_png and op.compression == "png", op.fragment_size or 0)
            answer = partial(self._outbox.answer, packing=packing)
            await call_service(self._node, op, self._turns, self._access, answer, self._on_request)
        finally:
            self._calls -= 1

    def _on_request(self, service: str, request: Message) -> None:
        self._leases.record(service, request)
        if self._leases:
            self._heartbeat.start()

    def _check_room(self, holdings: _Holdings) -> None:
        if len(holdings) >= self._settings.max_entities:
            raise PeerError(f"this client uses {len(holdings)} topics and services already, the limit")
        if (held := self._shared.held_by_all()) >= self._settings.max_entities_of_all:
            raise PeerError(f"all clients together use {held} topics and services already, the limit")

    def _report_slow(self) -> None:
        self._shared.counters.slowed_down += 1
        if self._slowness.allows("") is not None:
            limit = f"more than {self._settings.max_frames_per_second} frames a second"
            self._remark("warning", f"{limit} came from this client: it is being throttled to that rate", None)
            self._shared.error_log.log(
                f"slowed down {self._client.rpartition(':')[0]}",
                "door.slowed_down",
                f"{self._client} sends {limit}: it is being throttled to that rate",
                client=self._client,
            )

    def _report_taken(self, service: str) -> None:
        problem = f"service {service} is provided by a newer connection of the client {self._access.name} now"
        self._shared.error_log.log(
            f"taken over {self._client.rpartition(':')[0]}",
            "door.service_taken_over",
            f"{self._client}: {problem}",
            client=self._client,
            service=service,
        )
        self._remark("error", problem, None)

    def _report_unfit(self, op: str, topic: str, problem: str, identifier: Identifier = None) -> None:
        """Report that *op* is refused after all: the topic it waited for is of another type, or its message unfit."""
        error_text = f": {_refusal(op, topic, problem)}, now that it is used"
        self._log_error(error_text, op, problem, event="door.late_topic_unfit")
        self._remark("error", problem, identifier)

    def _log_error(self, error_text: str, op: str, problem: str, *, event: str = "door.refused") -> None:
        self.refused += 1
        self._shared.counters.requests_refused += 1
        self._shared.error_log.log(
            f"refused {self._client.rpartition(':')[0]}",
            event,
            f"{self._client}{error_text}",
            client=self._client,
            op=op,
            problem=problem,
            refused=self.refused,
        )

    def _answer(self, op: str, identifier: Identifier, target: str, problem: str) -> None:
        if op == "call_service":
            self._outbox.answer(service_failure(target, identifier, problem))
        elif op == "send_action_goal":
            self._outbox.answer(action_failure(target, identifier, problem))
        else:
            self._remark("error", problem, identifier)

    def _remark(self, level: Level, text: str, identifier: Identifier) -> None:
        """Send the client a remark, if it asked for those of this *level*."""
        if _SEVERITY[self._level] >= _SEVERITY[level]:
            self._outbox.answer(status_frame(level, text, identifier))


class _Kind(Protocol):
    """Entities of one kind."""

    def close_one(self) -> bool:
        """Give one back; return whether there was one."""
        ...


@dataclass(slots=True)
class _Holdings:
    """Everything that goes when the client goes."""

    publications: Publications
    subscriptions: Subscriptions
    services: ProvidedServices
    tasks: TaskGroup
    actions: ClientActions | None = None

    def __len__(self) -> int:
        return len(self.publications) + len(self.subscriptions) + len(self.services) + len(self.actions or ())

    @property
    def goals(self) -> int:
        """The number of goals that the client sent and that have not ended."""
        return self.actions.goals if self.actions is not None else 0

    async def close(self, turns: ServerTurns) -> None:
        """Give everything back, a little each time the event loop goes round."""
        kinds: tuple[_Kind | None, ...] = (self.actions, self.services, self.publications, self.subscriptions)
        for kind in kinds:
            while kind is not None and kind.close_one():
                await turns.turn()


def _refusal(op: str, name: str, problem: str) -> str:
    return f"{operation_text(op, name)} was refused: {problem}"
