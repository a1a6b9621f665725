"""A gateway on a broker in memory with a directory and an app, and a client on the devices' side."""

import json
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import asynccontextmanager
from dataclasses import dataclass

import anyio

from homebot.devices import Devices
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways import GatewayContext
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.connection import MqttConnection
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.mqtt.options import MqttOptions

Payload = str | Mapping[str, object] | Sequence[object]


@dataclass
class KnownHouse:
    """A gateway, a directory, and an app."""

    graph: Graph
    wire: MqttConnection
    devices: Devices
    directory: Directory

    async def say(self, topic: str, payload: Payload, *, retain: bool = False) -> None:
        text = payload if isinstance(payload, str) else json.dumps(payload)
        await self.wire.publish(topic, text.encode(), qos=1, retain=retain)
        await anyio.sleep(0.01)


@asynccontextmanager
async def known_house(
    before: Callable[[MqttConnection], Awaitable[None]] | None = None, **settings: object
) -> AsyncIterator[KnownHouse]:
    """Run the house after *before* is done at the broker; *settings* are those of the gateway."""
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
        if before is not None:
            await before(wire)
        table = MqttGatewaySettings.model_validate({"url": broker.url, **settings})
        gateway = MqttGateway(gateway_node, table, GatewayContext.of(HostedBroker.in_memory(broker)))
        directory = Directory(directory_node, DirectorySettings())
        await tasks.start(directory.serve)
        await tasks.start(gateway.serve)
        yield KnownHouse(graph, wire, Devices(app), directory)
        tasks.cancel_scope.cancel()
