"""The gateways of this machine, as the homebot of the house follows and commands them."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from math import inf
from typing import TYPE_CHECKING, Any, Final

import anyio
from anyio.abc import TaskStatus

from homebot.devices import GatewayNames, RawCommand
from homebot.devices.gateway_messages import Command
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.services import SubscribeToTopicResponse
from homebot.errors import HomebotError, PeerError, ServiceGoneError, ServiceTimeoutError
from homebot.features.machine.messages import (
    MAX_QUIET,
    MAX_SILENCE_S,
    CallGateway,
    CallGatewayRequest,
    CallGatewayResponse,
    FollowGateway,
    FollowGatewayRequest,
    FollowGatewayResponse,
    GetGateways,
    GetGatewaysRequest,
    GetGatewaysResponse,
    machine_name,
)
from homebot.features.machine.pending_updates import PendingUpdates
from homebot.graph import EntityKind, Node
from homebot.messages.cdr import message_from_cdr, message_to_cdr
from homebot.support.bounded_map import BoundedMap

if TYPE_CHECKING:
    from homebot.features.machine.wire import MachineWire
    from homebot.messages.message import Message

_MAX_AT_ONCE: Final = 50
"""Messages in an answer: a millisecond or two of writing."""

_PAUSE: Final = 0.01
"""Seconds between two answers that are not full: many devices that report at once share one."""

_MAX_CALLS: Final = 10_000
"""Calls that are remembered, so that none is carried out twice; older ones are late."""


async def serve_gateways(
    node: Node,
    wire: MachineWire,
    home: str,
    machine: str,
    gateways: tuple[str, ...],
    *,
    task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
) -> None:
    """Let the homebot of *home* follow and command *gateways*, until cancelled."""

    async def names(_: GetGatewaysRequest) -> GetGatewaysResponse:
        return GetGatewaysResponse(names=gateways)

    exports = {gateway: _GatewayExport(node, wire.session.id, gateway) for gateway in gateways}

    def health(_: HealthRequest) -> HealthResponse:
        alone = [] if wire.session.is_alone else [name for name, export in exports.items() if not export.is_followed]
        troubles = [
            f"no homebot of {home} follows {name}; does it have {machine} as a gateway, and run?" for name in alone
        ]
        return HealthResponse(counts=(), troubles=tuple(troubles))

    node.create_service(GetHealth, "~/health", health)
    for gateway, export in exports.items():
        wire.serve(machine_name(home, machine, gateway, "follow"), FollowGateway, export.follow)
        wire.serve(machine_name(home, machine, gateway, "call"), CallGateway, export.call)
    wire.serve(machine_name(home, machine, "gateways"), GetGateways, names)
    task_status.started()
    with closing(wire):
        await anyio.sleep_forever()


class _GatewayExport:
    """One gateway, as one homebot follows it: the last one that began."""

    def __init__(self, node: Node, session: str, gateway: str) -> None:
        self._node, self._session, self._names = node, session, GatewayNames(gateway)
        self._now = node.graph.clock.monotonic
        self._news = anyio.Event()
        self._waiting = PendingUpdates(node, gateway, self._wake)
        self._follower, self._number, self._full_at = "", 0, 0.0
        self._out = node.create_publisher(RawCommand, self._names.out, 1000)
        self._calls: BoundedMap[tuple[str, int], None] = BoundedMap(_MAX_CALLS)
        self._asked_at = -inf

    @property
    def is_followed(self) -> bool:
        """True if its news were asked for lately."""
        return self._now() < self._asked_at + 3 * MAX_QUIET

    async def follow(self, asked: FollowGatewayRequest) -> FollowGatewayResponse:
        """Return the news since the answer with the number *asked* has, or the first part of everything."""
        whole: Mapping[str, tuple[str, ...]] = {}
        self._asked_at = self._now()
        is_whole = not asked.number or (asked.follower, asked.number) != (self._follower, self._number)
        self._follower, self._number = asked.follower, self._number + 1
        number = self._number
        if is_whole:
            endpoints = self._node.graph.get_endpoints(kind=EntityKind.SERVICE, node=self._names.node)
            whole = {
                **self._waiting.begin(),
                "services": tuple(endpoint.name.rpartition("/")[2] for endpoint in endpoints),
            }
        elif not self._waiting:
            self._news = anyio.Event()
            with anyio.move_on_after(MAX_QUIET):
                await self._news.wait()
        await anyio.sleep(max(0.0, self._full_at - self._now()))
        if number != self._number:
            raise PeerError("it was asked again before it could answer")
        messages = self._waiting.pop(_MAX_AT_ONCE)
        self._full_at = self._now() + (0.0 if self._waiting else _PAUSE)
        fields: dict[str, Any] = {**whole, **messages}
        return FollowGatewayResponse(number=number, session=self._session, now=self._now(), is_whole=is_whole, **fields)

    async def call(self, asked: CallGatewayRequest) -> CallGatewayResponse:
        """Carry out a call in time, and once."""
        if asked.session != self._session or asked.follower != self._follower:
            raise PeerError("another homebot follows this gateway by now, or its machine has started anew")
        if (asked.follower, asked.id) in self._calls:
            raise PeerError("this call came before; it is carried out once")
        self._calls[asked.follower, asked.id] = None
        now = self._now()
        late = now - min(asked.until, asked.arrives_by, self._asked_at + MAX_SILENCE_S)
        if late >= 0.0:
            return CallGatewayResponse(success=False, message=f"it came {late:.2g} s too late, and was not carried out")
        try:
            response = await self._called(asked, asked.until - now)
        except HomebotError as exc:
            is_unanswered = isinstance(exc, ServiceTimeoutError | ServiceGoneError)
            return CallGatewayResponse(success=False, message=str(exc), is_unanswered=is_unanswered)
        return CallGatewayResponse(success=True, response=response)

    async def _called(self, asked: CallGatewayRequest, left: float) -> bytes:
        node = self._node
        if asked.service == "out":
            await self._out.send(message_from_cdr(RawCommand, asked.request))
            return b""
        name = f"{self._names.node}/{asked.service}"
        await node.graph.begin(name)
        service_type = node.graph.get_service_type(name)
        if service_type is None:
            raise PeerError(f"its gateway has no service {asked.service[:100]} now")
        request: Message = message_from_cdr(service_type.Request, asked.request)
        if isinstance(request, Command) and request.expires_after:
            request = request.model_copy(update={"expires_after": min(request.expires_after, left)})
        client = node.create_client(service_type, name)
        try:
            response = await client.call(request, asked.longest)
        finally:
            client.close()
        if isinstance(response, SubscribeToTopicResponse) and response.success:
            self._waiting.listen(response.data_topic)
        return message_to_cdr(response)

    def _wake(self) -> None:
        self._news.set()
