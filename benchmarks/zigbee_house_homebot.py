"""homebot's gateway and directory against a broker full of what Zigbee2MQTT retains, as ``homebot run`` has them.

``python zigbee_house_homebot.py PORT`` prints one JSON line: devices, parts, processor seconds until nothing more
happens, and seconds that an app waits for all devices.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time

import anyio

from homebot.cli.serve import short_collections
from homebot.devices import Devices
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.log import configure_logging

LOOK = 0.5
IDLE = 0.1
"""Part of a processor's time below which nothing happens any more."""
LOOKS = 4


async def until_idle() -> float:
    """Return the processor time of this process when it has been idle for two seconds, without these."""
    spent = ended = time.process_time()
    idle = 0
    while idle < LOOKS:
        await asyncio.sleep(LOOK)
        before, spent = spent, time.process_time()
        idle = idle + 1 if spent - before < IDLE * LOOK else 0
        ended = ended if idle else spent
    return ended


async def measure(port: int) -> dict[str, float]:
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "app") as app,
        anyio.create_task_group() as tasks,
    ):
        settings = MqttGatewaySettings(url=f"mqtt://127.0.0.1:{port}", act=True)
        MqttGateway.check(settings)  # as `homebot run` does before it starts anything
        before = time.process_time()
        directory = Directory(directory_node, DirectorySettings())
        await tasks.start(MqttGateway(gateway_node, settings).serve)
        await tasks.start(directory.serve)
        processor = await until_idle() - before
        asked = time.perf_counter()
        devices = await Devices(app).find()
        answered = time.perf_counter() - asked
        tasks.cancel_scope.cancel()
    parts = sum(len(device.parts) for device in devices)
    return {"devices": len(devices), "parts": parts, "processor": processor, "find": answered}


configure_logging(level="error")
with short_collections():
    print(json.dumps(asyncio.run(measure(int(sys.argv[1])))))
