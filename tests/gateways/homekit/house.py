"""A HomeKit gateway in virtual time, with accessories in memory."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio
from tests.gateways.homekit.fake_accessories import CODE, FakeMdns, FakePort, FakeServer

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.health import GetHealth, HealthRequest
from homebot.devices.names import PairingNames
from homebot.devices.pairing_messages import Pair, PairRequest, PairResponse, Unpair, UnpairRequest
from homebot.devices.value import PlainValue, Value
from homebot.gateways import GatewayContext
from homebot.gateways.homekit import HomekitGateway, HomekitGatewaySettings
from homebot.gateways.homekit.port import HomekitPort
from homebot.graph import Graph, Node, Subscription
from homebot.testing.gateway_contract import running
from homebot.testing.gateway_contract.steps import KEPT

PATIENCE = 60.0


@dataclass
class HomekitHouse:
    """The gateway, the network, and another node that watches."""

    gateway: HomekitGateway
    mdns: FakeMdns
    watcher: Node

    def sightings(self) -> Subscription[Sighting]:
        return self.watcher.create_subscription(Sighting, self.gateway.names.received_topics, qos_profile=KEPT)

    def reports(self) -> Subscription[Report]:
        return self.watcher.create_subscription(Report, self.gateway.names.readings, qos_profile=KEPT)

    async def sighted(self, sightings: Subscription[Sighting], until: Callable[[Sighting], object]) -> Sighting:
        with anyio.fail_after(PATIENCE):
            while not until(sighting := await sightings.receive()):
                pass
        return sighting

    async def pair(self, server: FakeServer, code: str) -> PairResponse:
        client = self.watcher.create_client(Pair, PairingNames("homekit").pair)
        return await client.call(PairRequest(device=server.key, code=code), timeout=PATIENCE)

    async def unpair(self, key: str) -> PairResponse:
        client = self.watcher.create_client(Unpair, PairingNames("homekit").unpair)
        return await client.call(UnpairRequest(device=key), timeout=PATIENCE)

    async def send(
        self, key: str, part: str, capability: str, value: PlainValue, expires_after: float = 0.0
    ) -> SendCommandResponse:
        command = Command(key=key, part=part, capability=capability, value=Value.of(value), expires_after=expires_after)
        client = self.watcher.create_client(SendCommand, self.gateway.names.send_command)
        return await client.call(command, timeout=PATIENCE)

    async def health(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The problems, and the notes."""
        client = self.watcher.create_client(GetHealth, self.gateway.names.health)
        answer = await client.call(HealthRequest(), timeout=PATIENCE)
        return answer.troubles, answer.notes


async def reading(reports: Subscription[Report], capability: str, wanted: PlainValue) -> Report:
    """Wait for a report in which *capability* is *wanted*."""
    with anyio.fail_after(PATIENCE):
        while True:
            report = await reports.receive()
            if any(one.capability == capability and one.value.plain() == wanted for one in report.readings):
                return report


@asynccontextmanager
async def house(*servers: FakeServer, pairings: Path | None = None) -> AsyncIterator[HomekitHouse]:
    graph = Graph()
    mdns = FakeMdns(graph)
    async with Node(graph, "homekit", namespace="/gateway") as node, Node(graph, "watcher") as watcher:
        context = GatewayContext(services={HomekitPort: FakePort(*servers)})
        gateway = HomekitGateway(node, HomekitGatewaySettings(pairings=pairings), context)
        async with running(gateway):
            for server in servers:
                mdns.announce(server)
            await anyio.wait_all_tasks_blocked()
            yield HomekitHouse(gateway, mdns, watcher)


@asynccontextmanager
async def paired(
    server: FakeServer, state: tuple[str, PlainValue] = ("on_off", False), pairings: Path | None = None
) -> AsyncIterator[tuple[HomekitHouse, Subscription[Report]]]:
    """A house with *server* paired, and its reports behind the first that has *state*: a capability with its value."""
    async with house(server, pairings=pairings) as home:
        assert (await home.pair(server, CODE)).success
        reports = home.reports()
        await reading(reports, *state)
        yield home, reports
