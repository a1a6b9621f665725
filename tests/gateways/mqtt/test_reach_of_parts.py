"""Availability of parts, from Home Assistant's announcement of a whole device to a handle."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass

import anyio
import pytest

from homebot.devices import Device, Devices
from homebot.devices.handles import Light, Switch
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.hosted_broker import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

pytestmark = pytest.mark.virtual_time

DEVICE = {"identifiers": ["panel-4711"], "name": "Panel"}
LAMP = {"platform": "light", "unique_id": "l", "command_topic": "p/l/set", "state_topic": "p/l"}
RELAY = {"platform": "switch", "unique_id": "s", "command_topic": "p/s/set", "state_topic": "p/s"}


@dataclass
class Home:
    wire: MqttConnection
    devices: Devices

    async def say(self, topic: str, payload: str | dict[str, object], *, retain: bool = False) -> None:
        text = payload if isinstance(payload, str) else json.dumps(payload)
        await self.wire.publish(topic, text.encode(), qos=1, retain=retain)
        await anyio.sleep(0.1)

    async def announce(self, *, lamp: dict[str, str], relay: dict[str, str], **common: object) -> None:
        components = {"l": {**LAMP, **lamp}, "s": {**RELAY, **relay}}
        origin = {"name": "test"}
        message = {"device": DEVICE, "origin": origin, "components": components, **common}
        await self.say("homeassistant/device/panel/config", message, retain=True)
        await anyio.sleep(1)

    async def panel(self) -> Device:
        (found,) = await self.devices.find()
        return found


@asynccontextmanager
async def home() -> AsyncIterator[Home]:
    graph = Graph()
    async with (
        MemoryBroker() as broker,
        Node(graph, "mqtt", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "app") as app,
        MqttConnection(MqttOptions.from_url(broker.url), broker.make_client, status_topic=None) as wire,
        anyio.create_task_group() as tasks,
    ):
        await wire.wait_connected()
        gateway = MqttGateway(
            gateway_node, MqttGatewaySettings(url=broker.url), GatewayContext.of(HostedBroker.in_memory(broker))
        )
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        await tasks.start(gateway.serve)
        yield Home(wire, Devices(app))
        tasks.cancel_scope.cancel()


async def test_each_component_tells_for_itself() -> None:
    async with home() as house:
        await house.announce(lamp={"availability_topic": "p/l/up"}, relay={"availability_topic": "p/s/up"})
        await house.say("p/l/up", "offline")
        await house.say("p/s/up", "online")
        panel = await house.panel()
        assert (panel.reachable.state, panel.offline_parts) == ("yes", ("l",))
        assert [one.reachable for one in await house.devices.find(Light)] == [False]
        assert [one.reachable for one in await house.devices.find(Switch)] == [True]
        assert not await house.devices.find(Light, reachable=True)
        assert len(await house.devices.find(Light, reachable=False)) == 1
        await house.say("p/l/up", "online")
        assert (await house.panel()).offline_parts == ()


async def test_one_that_is_offline_and_another_that_says_nothing_but_speaks() -> None:
    """As seen with a panel of which one entity alone has an availability topic."""
    async with home() as house:
        await house.announce(lamp={"availability_topic": "p/l/up"}, relay={})
        await house.say("p/l/up", "offline")
        await house.say("p/s", "ON")
        panel = await house.panel()
        assert (panel.reachable.state, panel.offline_parts, panel.freshness) == ("unknown", ("l",), "fresh")
        assert [one.reachable for one in await house.devices.find(Switch)] == [None]


async def test_what_all_share_is_of_the_device_and_what_one_has_comes_first() -> None:
    async with home() as house:
        await house.announce(lamp={}, relay={"availability_topic": "p/s/up"}, availability_topic="p/up")
        await house.say("p/up", "online")
        await house.say("p/s/up", "offline")
        assert ((await house.panel()).reachable.state, (await house.panel()).offline_parts) == ("yes", ("s",))
        await house.say("p/up", "offline")
        assert ((await house.panel()).reachable.state, (await house.panel()).offline_parts) == ("no", ("l", "s"))


async def test_an_announcement_without_availability_ends_what_was_said_before() -> None:
    async with home() as house:
        await house.announce(lamp={}, relay={}, availability_topic="p/up")
        await house.say("p/up", "offline")
        assert (await house.panel()).reachable.state == "no"
        await house.announce(lamp={}, relay={})
        assert ((await house.panel()).reachable.state, (await house.panel()).offline_parts) == ("unknown", ())
