"""The mDNS gateway and Avahi see each other, on a network of their own."""

import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.patience import PATIENCE
from tests.peers.avahi import avahi, why_no_avahi
from tests.peers.network import INTERFACE, Lan, Machine

from homebot.devices import GatewayState, Sighting
from homebot.devices.device import KeyValue
from homebot.devices.exposure import NETWORK_SERVICES, NETWORK_SERVICES_QOS, NetworkService
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.graph import Graph, Node, Subscription

pytestmark = pytest.mark.skipif(bool(why_no_avahi()), reason=why_no_avahi())


@asynccontextmanager
async def gateway(**settings: object) -> AsyncIterator[tuple[MdnsGateway, Node]]:
    """A gateway on the machine of the test, and another node of its graph."""
    table = {"interfaces": [INTERFACE], "announce": False, **settings}
    graph = Graph()
    async with Node(graph, "watcher") as watcher, Node(graph, "mdns", namespace="/gateway") as node:
        made = MdnsGateway(node, MdnsGatewaySettings.model_validate(table))
        async with anyio.create_task_group() as tasks:
            await tasks.start(made.serve)
            yield made, watcher
            tasks.cancel_scope.cancel()


def sightings(gateway: MdnsGateway, watcher: Node) -> Subscription[Sighting]:
    return watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=100)


async def next_about(news: Subscription[Sighting], name: str) -> Sighting:
    with anyio.fail_after(PATIENCE):
        while (sighting := await news.receive()).name != name:
            pass
    return sighting


@pytest.mark.newest("mdns")
async def test_what_avahi_publishes_is_listed_with_its_facts_until_it_says_goodbye(lan: Lan, hub: Machine) -> None:
    computer = lan.machine("shellyplus1-a8032abe54dc")
    publish = (
        "avahi-publish",
        "-s",
        "Häll lamp",
        "_demo-lamp._tcp",
        "4711",
        "model=Lamp 1",
        "ver=1.2",
        "flag",
        "bin=\x01",
    )
    async with gateway(service_types=["_services._dns-sd._udp"]) as (mdns, watcher):
        news = sightings(mdns, watcher)
        async with avahi(computer, *publish, ready="Established") as program:
            found = await next_about(news, "Häll lamp")
            facts = {one.key: one.value for one in found.metadata}
            assert found.kind == "appeared"
            assert found.key == "Häll lamp._demo-lamp._tcp.local."
            assert found.service_type == "_demo-lamp._tcp"
            assert facts["host"] == "shellyplus1-a8032abe54dc.local"
            assert (facts["port"], facts["ip_address"]) == ("4711", computer.address)
            assert (facts["model"], facts["sw_version"]) == ("Lamp 1", "1.2")
            assert facts["txt_bin"] == "\N{REPLACEMENT CHARACTER}"
            assert "mac:a8032abe54dc" in found.identifiers
            program.end()
            gone = await next_about(news, "Häll lamp")
            assert (gone.kind, gone.why) == ("removed", "it said goodbye")


async def test_avahi_finds_homebot_with_name_version_and_id_until_it_stops(lan: Lan, hub: Machine) -> None:
    async with avahi(
        lan.machine("neighbour"), "avahi-browse", "-prk", "_homebot._tcp", ready="Server startup"
    ) as browser:
        async with gateway(announce=True, announce_as="Robot, the 1st"):
            shown = await browser.prints("=;e0;IPv4;Robot")
            line = next(one for one in shown.splitlines() if one.startswith("=;"))
            assert re.fullmatch(r"robot--the-1st-homebot-[0-9a-f]{8}\.local", line.split(";")[6])
            assert line.split(";")[7:9] == [hub.address, "0"]
            assert '"name=Robot, the 1st"' in line
            assert '"version=' in line
            assert re.search(r'"id=[0-9a-f]{16}"', line)
        await browser.prints("-;e0;IPv4;Robot")


async def test_avahi_tells_two_homebots_of_one_computer_apart(lan: Lan, hub: Machine) -> None:
    command = ("avahi-browse", "-prk", "_homebot._tcp")
    own = {"announce": True, "announce_as": "robot", "service_types": ["_homebot._tcp"]}
    async with avahi(lan.machine("neighbour"), *command, ready="Server startup") as browser, gateway(**own):
        await browser.prints("=;e0;IPv4;robot;")
        async with gateway(**own):
            shown = await browser.prints("=;e0;IPv4;robot-2;")
            lines = [one.split(";", 9) for one in shown.splitlines() if one.startswith("=;")]
            assert {one[3] for one in lines} == {"robot", "robot-2"}
            assert len({one[6] for one in lines}) == 2
            assert len({id_ for one in lines for id_ in re.findall(r'"id=([0-9a-f]{16})"', one[9])}) == 2
            assert {one[7] for one in lines} == {hub.address}
        shown = await browser.prints("-;e0;IPv4;robot-2;")
        assert "-;e0;IPv4;robot;" not in shown


async def test_avahi_finds_what_homebot_serves_to_the_network_and_nothing_that_is_for_this_computer_alone(
    lan: Lan, hub: Machine
) -> None:
    command = ("avahi-browse", "-pra")
    async with (
        avahi(lan.machine("neighbour"), *command, ready="Server startup") as browser,
        gateway(announce=True, announce_as="robot") as (_, watcher),
    ):
        served = watcher.create_publisher(NetworkService, NETWORK_SERVICES, NETWORK_SERVICES_QOS)
        served.publish(NetworkService(service_type="_private._tcp", addresses=("127.0.0.1", "::1"), port=9090))
        served.publish(NetworkService(service_type="_rosbridge._tcp", addresses=("0.0.0.0",), port=9091))  # noqa: S104
        facts = (KeyValue(key="td", value="/.well-known/wot"), KeyValue(key="type", value="Directory"))
        directory = NetworkService(
            service_type="_directory._sub._wot._tcp", addresses=(hub.address,), port=9092, facts=facts
        )
        served.publish(directory)
        shown = await browser.prints("=;e0;IPv4;robot;_rosbridge._tcp;local;robot-homebot-")
        assert ".local;10.77.0.1;9091;" in shown.partition("=;e0;IPv4;robot;_rosbridge._tcp;")[2]
        assert "_private._tcp" not in shown
        async with avahi(
            lan.machine("client"), "avahi-browse", "-pr", "_directory._sub._wot._tcp", ready="9092"
        ) as client:
            assert '"td=/.well-known/wot"' in "".join(client.printed)
            served.publish(directory.model_copy(update={"is_withdrawn": True}))
            await client.prints("-;e0;IPv4;robot")


async def test_without_its_interface_the_gateway_is_unavailable_and_comes_back(lan: Lan, hub: Machine) -> None:
    async with gateway(service_types=["_demo-lamp._tcp"]) as (mdns, watcher):
        states = watcher.create_subscription(GatewayState, mdns.names.state, qos_profile=10)
        news = sightings(mdns, watcher)
        publish = ("avahi-publish", "-s", "Hall", "_demo-lamp._tcp", "4711")
        async with avahi(lan.machine("hall"), *publish, ready="Established"):
            await next_about(news, "Hall")
            await hub.run("ip", "addr", "flush", "dev", INTERFACE)
            with anyio.fail_after(PATIENCE):
                while (state := await states.receive()).state != "unavailable":
                    pass
            assert state.reason == "there is no network interface e0"
            await hub.run("ip", "addr", "add", f"{hub.address}/24", "dev", INTERFACE)
            with anyio.fail_after(PATIENCE):
                while (await states.receive()).state != "active":
                    pass
            assert mdns.devices.keys == ("Hall._demo-lamp._tcp.local.",)
