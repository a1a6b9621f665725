"""Devices that announce themselves on loopback are found by the mDNS gateway, listed, and obey."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest
from tests.integrations.shelly.simulated.web_device import ServedShelly
from tests.integrations.wled.simulated.web_device import ServedWled
from tests.loopback import alone_on_loopback
from tests.patience import PATIENCE

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Command, Report, SendCommand, SendCommandResponse
from homebot.devices.value import Value
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings
from homebot.graph import DurabilityPolicy, Graph, Node, QoSProfile
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo

LOOPBACK = "127.0.0.1"
KEPT = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)


def lamp(name: str) -> SimulatedDeviceInfo:
    return SimulatedDeviceInfo("found", "lamp", name, "lights", "hall")


@asynccontextmanager
async def house(device: ServedShelly | ServedWled, service_type: str) -> AsyncIterator[tuple[Node, MdnsGateway]]:
    """Run a device, the gateway and another node on its graph."""
    graph = Graph()
    device.begin(DeviceState(text="off", brightness=0.4), has_power=True)
    settings = MdnsGatewaySettings(interfaces=(LOOPBACK,), service_types=(service_type,), announce=False)
    async with (
        alone_on_loopback(),
        Node(graph, "watcher") as watcher,
        Node(graph, "mdns", namespace="/gateway") as node,
    ):
        gateway = MdnsGateway(node, settings)
        async with anyio.create_task_group() as tasks:
            await tasks.start(gateway.serve)
            await tasks.start(device.serve)
            yield watcher, gateway
            tasks.cancel_scope.cancel()


async def found_and_turned_on(watcher: Node, gateway: MdnsGateway, name: str) -> Sighting:
    """Wait until a device called *name* has parts, turn it on, and return its sighting when it says that it is on."""
    sightings = watcher.create_subscription(Sighting, gateway.names.received_topics, qos_profile=KEPT)
    reports = watcher.create_subscription(Report, gateway.names.readings, qos_profile=KEPT)
    client = watcher.create_client(SendCommand, gateway.names.send_command)
    with anyio.fail_after(PATIENCE):
        while not ((sighting := await sightings.receive()).name == name and sighting.parts):
            pass
        part = sighting.parts[0].id
        response = await client.call(
            Command(key=sighting.key, part=part, capability="on_off", value=Value.of(True)), timeout=PATIENCE
        )
        assert isinstance(response, SendCommandResponse)
        assert response.success, response.message
        while not any(
            one.part == part and one.capability == "on_off" and one.value.plain() is True
            for one in (await reports.receive()).readings
        ):
            pass
    return sighting


@pytest.mark.parametrize("kind", ["shelly", "wled"])
async def test_a_device_is_found_listed_and_turned_on(kind: str) -> None:
    def obey(text: str) -> None:
        device.publish(DeviceState(text=text, is_on=text == "on", brightness=0.4))

    device: ServedShelly | ServedWled
    if kind == "shelly":
        device = ServedShelly(lamp("Found dimmer"), obey, announced=True)
    else:
        device = ServedWled(lamp("Found strip"), obey, announced=True)
    async with house(device, f"_{kind}._tcp") as (watcher, gateway):
        sighting = await found_and_turned_on(watcher, gateway, device.device.device_id)
    assert sighting.identifiers
    assert sighting.key.endswith(f"._{kind}._tcp.local.")
    assert sighting.parts[0].service_type == "light"
