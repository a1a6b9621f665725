"""A gateway for CoAP, and what it publishes."""

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager

from tests.gateways.watched_gateway import WatchedGateway, reading, receive

from homebot.clock import Clock
from homebot.devices import Sighting
from homebot.devices.gateway_messages import SendCommandResponse
from homebot.devices.value import PlainValue
from homebot.gateways.coap import CoapGateway, CoapGatewaySettings
from homebot.graph import Graph, Node
from homebot.testing.gateway_contract import running


class Watcher(WatchedGateway):
    """What a gateway publishes, and commands to its devices."""

    gateway: CoapGateway

    def __init__(self, watcher: Node, gateway: CoapGateway) -> None:
        self.watcher, self.gateway = watcher, gateway
        self._sightings, self._reports = self.sightings(), self.reports()

    async def sighting(self, is_it: Callable[[Sighting], bool]) -> Sighting:
        return await receive(self._sightings, is_it)

    async def reported(self, capability: str, value: PlainValue | Callable[[PlainValue], bool]) -> PlainValue:
        return await reading(self._reports, capability, value)

    async def tell(self, key: str, capability: str, value: PlainValue) -> SendCommandResponse:
        return await self.command(key, "", capability, value)


@asynccontextmanager
async def watched_gateway(clock: Clock | None = None, /, **settings: object) -> AsyncIterator[Watcher]:
    """Run a gateway with these settings inside the block."""
    graph = Graph(clock)
    async with Node(graph, "watcher") as node, Node(graph, "coap", namespace="/gateway") as own:
        made = CoapGateway(own, CoapGatewaySettings.model_validate(settings))
        watcher = Watcher(node, made)
        async with running(made):
            yield watcher
