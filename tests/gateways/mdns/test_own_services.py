"""Others see homebot on the network, and what it serves to them; in-process, with zeroconf as the other."""

import json
import os
import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
from tests.gateways.mdns.lamp import LOOPBACK
from tests.patience import PATIENCE
from zeroconf import IPVersion, ServiceStateChange
from zeroconf.asyncio import AsyncServiceBrowser, AsyncServiceInfo, AsyncZeroconf

import homebot
from homebot.devices.exposure import NETWORK_SERVICES, NETWORK_SERVICES_QOS, NetworkService
from homebot.gateways.announced.counters import GatewayCounters
from homebot.gateways.base import GatewayContext
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.gateways.mdns.network import OwnService, ServiceNews
from homebot.gateways.mdns.zeroconf_network import MdnsNetwork
from homebot.graph import Graph, Node, Publisher
from homebot.support.installation import INSTALLATION_FILE, Installation

KEPT = json.dumps({"id": f"{os.getpid():016x}", "names": {}})
NAME = f"robot {os.getpid()}"
ANY = "0.0.0.0"  # noqa: S104
DOOR = NetworkService(service_type="_rosbridge._tcp", addresses=(ANY,), port=9090)


@asynccontextmanager
async def announcing(
    installation: Installation | None = None,
) -> AsyncIterator[tuple[Publisher[NetworkService], AsyncZeroconf]]:
    """A gateway that announces, what publishes services to it, and another program on the network."""
    graph = Graph()
    context = GatewayContext.of(*(() if installation is None else (installation,)))
    settings = MdnsGatewaySettings(interfaces=(LOOPBACK,), service_types=("_homebot._tcp",), announce_as=NAME)
    other = AsyncZeroconf(interfaces=[LOOPBACK], ip_version=IPVersion.V4Only)
    try:
        async with Node(graph, "web") as web, Node(graph, "mdns", namespace="/gateway") as node:
            services = web.create_publisher(NetworkService, NETWORK_SERVICES, NETWORK_SERVICES_QOS)
            async with anyio.create_task_group() as tasks:
                await tasks.start(MdnsGateway(node, settings, context).serve)
                yield services, other
                tasks.cancel_scope.cancel()
    finally:
        await other.async_close()
        if installation is not None:
            installation.close()


async def look(
    other: AsyncZeroconf, service_type: str, *, port: int | None = None, is_there: bool = True, name: str = NAME
) -> AsyncServiceInfo:
    """Look until a service of homebot is there, with a port, or is not."""
    with anyio.fail_after(PATIENCE):
        while True:
            info = AsyncServiceInfo(f"{service_type}.local.", f"{name}.{service_type}.local.")
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
        assert re.fullmatch(r"[0-9a-f]{16}", said["id"] or "")


async def test_a_reachable_service_is_announced_until_it_is_withdrawn() -> None:
    async with announcing() as (services, other):
        services.publish(DOOR)
        info = await look(other, "_rosbridge._tcp", port=9090)
        assert info.parsed_addresses() == [LOOPBACK]
        await look(other, "_homebot._tcp", port=9090)
        services.publish(DOOR.model_copy(update={"is_withdrawn": True}))
        await look(other, "_rosbridge._tcp", is_there=False)
        await look(other, "_homebot._tcp", port=0)


async def test_homebot_stays_known_while_its_records_change() -> None:
    """A goodbye before each change would let it leave and return in other homebots' lists."""
    changes: list[ServiceStateChange] = []

    def note(name: str, state_change: ServiceStateChange, **_: object) -> None:
        if name.startswith(NAME):
            changes.append(state_change)

    async with announcing() as (services, other):
        await look(other, "_homebot._tcp")
        browser = AsyncServiceBrowser(other.zeroconf, "_homebot._tcp.local.", handlers=[note])
        services.publish(DOOR)
        await look(other, "_homebot._tcp", port=9090)
        services.publish(DOOR.model_copy(update={"port": 9091}))
        await look(other, "_homebot._tcp", port=9091)
        assert ServiceStateChange.Removed not in changes
        await browser.async_cancel()
    assert changes[0] is ServiceStateChange.Added


async def test_another_address_of_this_computer_is_announced() -> None:
    news: list[ServiceNews] = []
    other = AsyncZeroconf(interfaces=[LOOPBACK], ip_version=IPVersion.V4Only)
    try:
        async with MdnsNetwork.opened((LOOPBACK,), news.append, GatewayCounters()) as network:
            await network.announce(OwnService("_homebot._tcp", NAME, f"robot-{os.getpid()}", 0))
            assert (await look(other, "_homebot._tcp")).parsed_addresses() == [LOOPBACK]
            await network.change_interfaces((LOOPBACK, "127.0.0.2"))
            with anyio.fail_after(PATIENCE):
                while "127.0.0.2" not in (await look(other, "_homebot._tcp")).parsed_addresses():  # noqa: ASYNC110
                    await anyio.sleep(0.05)  # another program tells nobody
    finally:
        await other.async_close()
    assert not [one for one in news if one.name.startswith(NAME)]


async def test_a_local_service_is_not_announced() -> None:
    async with announcing() as (services, other):
        private = DOOR.model_copy(update={"service_type": "_private._tcp", "addresses": ("127.0.0.1", "::1")})
        services.publish(private)
        services.publish(DOOR)
        await look(other, "_rosbridge._tcp", port=9090)
        info = AsyncServiceInfo("_private._tcp.local.", f"{NAME}._private._tcp.local.")
        assert not await info.async_request(other.zeroconf, 500)


async def test_two_homebots_of_one_name_are_told_apart_and_one_stays_when_the_other_leaves(tmp_path: Path) -> None:
    """Their addresses are the same, so that the goodbye of a shared host name would take both away."""
    second_name = f"{NAME}-2"
    files = [tmp_path / name / INSTALLATION_FILE for name in ("first", "second")]
    async with announcing(Installation(files[0])) as (services, other):
        first = await look(other, "_homebot._tcp")
        async with announcing(Installation(files[1])) as (second_services, _):
            second_services.publish(DOOR)
            second = await look(other, "_homebot._tcp", name=second_name, port=9090)
            await look(other, "_rosbridge._tcp", name=second_name)
            services.publish(DOOR.model_copy(update={"port": 9091}))
            await look(other, "_homebot._tcp", port=9091)
            assert second.server != first.server
            assert second.decoded_properties["id"] != first.decoded_properties["id"]
            assert second.decoded_properties["name"] == NAME
        await look(other, "_homebot._tcp", name=second_name, is_there=False)
        await look(other, "_homebot._tcp", port=9091)
    async with announcing(Installation(files[1])) as (_, other):
        again = await look(other, "_homebot._tcp", name=second_name)
        assert (again.server, again.decoded_properties["id"]) == (second.server, second.decoded_properties["id"])


async def test_of_two_homebots_with_one_id_one_takes_another(tmp_path: Path) -> None:
    """Such as two computers of which one is a copy of the other."""
    original, copy = tmp_path / "original.json", tmp_path / "copy.json"
    original.write_text(KEPT)
    copy.write_text(KEPT)
    async with announcing(Installation(original)) as (_, other):
        first = (await look(other, "_homebot._tcp")).decoded_properties["id"]
        async with announcing(Installation(copy)):
            with anyio.fail_after(PATIENCE):
                while True:
                    said = (await look(other, "_homebot._tcp", name=f"{NAME}-2")).decoded_properties["id"]
                    if said != first:
                        break
                    await anyio.sleep(0.05)  # another program tells nobody
            assert (await look(other, "_homebot._tcp")).decoded_properties["id"] == first
    assert json.loads(copy.read_text())["id"] != json.loads(KEPT)["id"] == json.loads(original.read_text())["id"]
