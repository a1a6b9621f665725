"""A HomeKit gateway in virtual time, with accessories in memory."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio
from tests.gateways.watched_gateway import WatchedGateway, reading, watched
from tests.integrations.homekit.gateway.fake_accessories import CODE, FakeMdns, FakePort, FakeServer

from homebot.devices.gateway_messages import Report
from homebot.devices.value import PlainValue
from homebot.gateways import GatewayContext
from homebot.gateways.pairing import PairResponse
from homebot.graph import Graph, Node, Subscription
from homebot.integrations.homekit.gateway import HomekitGateway, HomekitGatewaySettings
from homebot.integrations.homekit.gateway.port import HomekitPort


@dataclass
class HomekitHouse(WatchedGateway):
    """The gateway and the network."""

    gateway: HomekitGateway
    mdns: FakeMdns
    watcher: Node

    async def pair(self, server: FakeServer, code: str) -> PairResponse:
        return await self.pair_with(server.key, code)


@asynccontextmanager
async def house(*servers: FakeServer, pairings: Path | None = None) -> AsyncIterator[HomekitHouse]:
    context = GatewayContext(services={HomekitPort: FakePort(*servers)})
    settings, mdns = HomekitGatewaySettings(pairings=pairings), FakeMdns(graph := Graph())
    async with watched("homekit", lambda node: HomekitGateway(node, settings, context), graph) as (gateway, watcher):
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
