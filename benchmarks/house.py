"""A homebot with one MQTT gateway, the directory and one app, in the running event loop."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import TypeAlias

import anyio

from homebot.devices import Device, Devices, RawMessage
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.mqtt.clients import MqttClientName
from raw_mqtt import connect, publish_packet

__all__ = ["homebot_listening", "lamp_topics"]

MakeHandler: TypeAlias = Callable[[Devices, Device], Callable[[RawMessage], Awaitable[None] | None]]


def lamp_topics(lamps: int) -> list[str]:
    return [f"bench/lights/lamp{number}/out" for number in range(lamps)]


@asynccontextmanager
async def homebot_listening(
    port: int, lamps: int, make_handler: MakeHandler, *, client: MqttClientName = "native"
) -> AsyncIterator[None]:
    """Run homebot inside the block; entering returns when the app listens to all *lamps*.

    Args:
        port: Of the broker.
        lamps: How many, at most 10; each says something once, so that it is discovered.
        make_handler: Returns what handles the messages of a device.
        client: What the gateway speaks MQTT with.
    """
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "app") as app_node,
        anyio.create_task_group() as tasks,
    ):
        settings = MqttGatewaySettings(url=f"mqtt://127.0.0.1:{port}", root="bench", act=True, client=client)
        gateway = MqttGateway(gateway_node, settings)
        await tasks.start(gateway.serve)
        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        await _listen_to_all(port, lamps, Devices(app_node), make_handler)
        yield
        tasks.cancel_scope.cancel()


async def _listen_to_all(port: int, lamps: int, devices: Devices, make_handler: MakeHandler) -> None:
    with connect(port, "bench-first-words") as sock:
        for topic in lamp_topics(lamps):
            sock.sendall(publish_packet(topic, b"00000000"))
        listening = 0
        async with asyncio.timeout(10):
            async for change in devices.follow("lights"):
                if change.kind == "appeared":
                    await devices.listen(change.device, make_handler(devices, change.device))
                    listening += 1
                    if listening == lamps:
                        break
    await asyncio.sleep(0.05)  # what the lamps said first is handled before anything is counted
