"""A gateway for CoAP, and what it publishes."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

import anyio
from tests.patience import PATIENCE

from homebot.devices import GatewayState, Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.devices.value import PlainValue, Value
from homebot.gateways.coap import CoapGateway, CoapGatewaySettings
from homebot.graph import Graph, Node
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import KEPT

__all__ = ["Watcher", "watched_gateway"]


class Watcher:
    """What a gateway publishes, and commands to its devices."""

    def __init__(self, node: Node, gateway: CoapGateway) -> None:
        self.gateway = gateway
        self._node = node
        self.states = node.create_subscription(GatewayState, gateway.names.state, qos_profile=KEPT)
        self.sightings = node.create_subscription(Sighting, gateway.names.received_topics, qos_profile=KEPT)
        self.reports = node.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)

    async def sighting(self, is_it: Callable[[Sighting], bool]) -> Sighting:
        """Wait for a sighting."""
        with anyio.fail_after(PATIENCE):
            while not is_it(sighting := await self.sightings.receive()):
                pass
        return sighting

    async def reported(self, capability: str, *values: PlainValue) -> PlainValue:
        """Wait for a value, one of *values* if there are any."""
        with anyio.fail_after(PATIENCE):
            while True:
                for one in (await self.reports.receive()).readings:
                    if one.capability == capability and (not values or one.value.plain() in values):
                        return one.value.plain()

    async def tell(self, key: str, capability: str, value: PlainValue) -> SendCommandResponse:
        """Send a command."""
        client = self._node.create_client(SendCommand, self.gateway.names.send_command)
        return await client.call(
            Command(key=key, part="", capability=capability, value=Value.of(value)), timeout=PATIENCE
        )

    async def health(self) -> HealthResponse:
        """Return what the doctor shows of the gateway."""
        client = self._node.create_client(GetHealth, self.gateway.names.health)
        return await client.call(HealthRequest(), timeout=PATIENCE)


@asynccontextmanager
async def watched_gateway(**settings: object) -> AsyncIterator[Watcher]:
    """Run a gateway with these settings inside the block."""
    graph = Graph()
    async with Node(graph, "watcher") as node, Node(graph, "coap", namespace="/gateway") as own:
        made = CoapGateway(own, CoapGatewaySettings.model_validate(settings))
        watcher = Watcher(node, made)
        async with running(made):
            yield watcher
