"""Others see homebot on the network, and what it serves to them; in-process, with zeroconf as the other."""

from __future__ import annotations

import os
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from tests.gateways.mdns.lamp import LOOPBACK
from tests.patience import PATIENCE
from zeroconf import IPVersion
from zeroconf.asyncio import AsyncServiceInfo, AsyncZeroconf

import homebot
from homebot.devices.network_service import NETWORK_SERVICES, NETWORK_SERVICES_QOS, NetworkService
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.gateways.mdns.own_services import installation_facts
from homebot.graph import Graph, Node, Publisher

ID = installation_facts("/gateway/mdns")["id"]
NAME = f"robot {os.getpid()}"
ANY = "0.0.0.0"  # noqa: S104
DOOR = NetworkService(service_type="_rosbridge._tcp", addresses=(ANY,), port=9090)


@asynccontextmanager
async def announcing() -> AsyncIterator[tuple[Publisher[NetworkService], AsyncZeroconf]]:
    """A gateway that announces, what publishes services to it, and another program on the network."""
    graph = Graph()
    settings = MdnsGatewaySettings(interfaces=(LOOPBACK,), service_types=("_nothing._tcp",), announce_as=NAME)
    other = AsyncZeroconf(interfaces=[LOOPBACK], ip_version=IPVersion.V4Only)
    try:
        async with Node(graph, "web") as web, Node(graph, "mdns", namespace="/gateway") as node:
            services = web.create_publisher(NetworkService, NETWORK_SERVICES, NETWORK_SERVICES_QOS)
            async with anyio.create_task_group() as tasks:
                await tasks.start(MdnsGateway(node, settings).serve)
                yield services, other
                tasks.cancel_scope.cancel()
    finally:
        await other.async_close()


async def look(
    other: AsyncZeroconf, service_type: str, *, port: int | None = None, is_there: bool = True
) -> AsyncServiceInfo:
    """Look until a service of homebot is there, with a port, or is not."""
    with anyio.fail_after(PATIENCE):
        while True:
            info = AsyncServiceInfo(f"{service_type}.local.", f"{NAME}.{service_type}.local.")
            found = await info.async_request(other.zeroconf, 500)
            if found is is_there and (port is None or info.port == port):
                return info
            await anyio.sleep(0.05)  # another program tells nobody


async def test_homebot_is_seen_with_its_name_version_and_id() -> None:
    async with announcing() as (_, other):
        info = await look(other, "_homebot._tcp")
        assert info.port == 0
        said = info.decoded_properties
        assert (said["name"], said["version"]) == (NAME, homebot.__version__)
        assert said["id"] == ID


async def test_what_others_can_reach_is_announced_until_it_is_withdrawn() -> None:
    async with announcing() as (services, other):
        services.publish(DOOR)
        info = await look(other, "_rosbridge._tcp", port=9090)
        assert info.parsed_addresses() == [LOOPBACK]
        await look(other, "_homebot._tcp", port=9090)
        services.publish(DOOR.model_copy(update={"is_withdrawn": True}))
        await look(other, "_rosbridge._tcp", is_there=False)
        await look(other, "_homebot._tcp", port=0)


async def test_what_is_for_this_computer_alone_is_not_announced() -> None:
    async with announcing() as (services, other):
        private = DOOR.model_copy(update={"service_type": "_private._tcp", "addresses": ("127.0.0.1", "::1")})
        services.publish(private)
        services.publish(DOOR)
        await look(other, "_rosbridge._tcp", port=9090)
        info = AsyncServiceInfo("_private._tcp.local.", f"{NAME}._private._tcp.local.")
        assert not await info.async_request(other.zeroconf, 500)


def test_an_id_tells_two_gateways_apart_and_stays_the_same() -> None:
    first, second = installation_facts("/gateway/mdns"), installation_facts("/gateway/other")
    assert first["id"] != second["id"]
    assert first == installation_facts("/gateway/mdns")
