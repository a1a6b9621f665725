"""A gateway on a graph, and another node that follows and commands it."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from typing import TypeVar

import anyio
from tests.patience import PATIENCE

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import (
    Command,
    RefreshPart,
    RefreshRequest,
    RefreshResponse,
    Report,
    SendCommand,
    SendCommandResponse,
)
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.names import PairingNames
from homebot.devices.value import PlainValue, Value
from homebot.gateways import Gateway
from homebot.gateways.pairing import Pair, PairRequest, PairResponse, Unpair, UnpairRequest
from homebot.graph import Graph, Node, Subscription
from homebot.messages.message import Message
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import KEPT

GatewayT = TypeVar("GatewayT", bound=Gateway)
MessageT = TypeVar("MessageT", bound=Message)


class WatchedGateway:
    """The gateway, as *watcher* sees it."""

    gateway: Gateway
    watcher: Node

    def reports(self) -> Subscription[Report]:
        return self.watcher.create_subscription(Report, self.gateway.names.readings, qos_profile=KEPT)

    def sightings(self) -> Subscription[Sighting]:
        return self.watcher.create_subscription(Sighting, self.gateway.names.received_topics, qos_profile=KEPT)

    def states(self) -> Subscription[GatewayState]:
        return self.watcher.create_subscription(GatewayState, self.gateway.names.state, qos_profile=KEPT)

    async def command(
        self, key: str, part: str, capability: str, value: PlainValue, expires_after: float = 0.0, code: str = ""
    ) -> SendCommandResponse:
        wanted = {"value": Value.of(value), "expires_after": expires_after, "code": code}
        command = Command.model_validate({"key": key, "part": part, "capability": capability, **wanted})
        client = self.watcher.create_client(SendCommand, self.gateway.names.send_command)
        return await client.call(command, timeout=PATIENCE)

    async def refresh(self, key: str, part: str) -> RefreshResponse:
        client = self.watcher.create_client(RefreshPart, self.gateway.names.refresh)
        return await client.call(RefreshRequest(key=key, part=part), timeout=PATIENCE)

    async def pair_with(self, key: str, code: str) -> PairResponse:
        client = self.watcher.create_client(Pair, PairingNames(self.gateway.node.name).pair)
        return await client.call(PairRequest(device=key, code=code), timeout=PATIENCE)

    async def unpair_from(self, key: str) -> PairResponse:
        client = self.watcher.create_client(Unpair, PairingNames(self.gateway.node.name).unpair)
        return await client.call(UnpairRequest(device=key), timeout=PATIENCE)

    async def health(self) -> HealthResponse:
        client = self.watcher.create_client(GetHealth, self.gateway.names.health)
        return await client.call(HealthRequest(), timeout=PATIENCE)


@asynccontextmanager
async def watched(
    name: str, make: Callable[[Node], GatewayT], graph: Graph | None = None
) -> AsyncIterator[tuple[GatewayT, Node]]:
    """Run a gateway inside the block; yield it and its watcher."""
    graph = graph or Graph()
    async with Node(graph, name, namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        gateway = make(node)
        async with running(gateway):
            yield gateway, watcher


async def receive(messages: Subscription[MessageT], fits: Callable[[MessageT], object]) -> MessageT:
    """Wait for a message that fits."""
    with anyio.fail_after(PATIENCE):
        while not fits(message := await messages.receive()):
            pass
    return message


async def reading(
    reports: Subscription[Report], capability: str, wanted: PlainValue | Callable[[PlainValue], bool]
) -> PlainValue:
    """Wait until a capability has a value, or one that fits; return it."""
    with anyio.fail_after(PATIENCE):
        while True:
            for one in (await reports.receive()).readings:
                value = one.value.plain()
                if one.capability == capability and (wanted(value) if callable(wanted) else value == wanted):
                    return value
