"""homebot's gateway and directory with a follower of all lights, as ``homebot run`` has them.

``python states_homebot.py PORT LAMPS CLIENT`` prints what states_home_assistant.py does.
"""

from __future__ import annotations

import asyncio
import json
import sys
import time

import anyio

from homebot.cli.serve import short_collections
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.discovery import Directory, DirectorySettings
from homebot.gateways.mqtt import MqttGateway, MqttGatewaySettings
from homebot.graph import Graph, Node
from homebot.log import configure_logging

LAST_LEVEL = 100.0  # percent


async def main(port: int, count: int, client: str) -> None:
    levels: dict[str, float | None] = {}
    graph = Graph()
    async with (
        Node(graph, "mqtt", namespace="/gateway") as gateway_node,
        Node(graph, "discovery") as directory_node,
        Node(graph, "app") as app_node,
        anyio.create_task_group() as tasks,
    ):

        async def follow() -> None:
            async for change in Devices(app_node).follow(Light):
                levels[change.handle.id] = change.handle.level

        await tasks.start(Directory(directory_node, DirectorySettings()).serve)
        settings = MqttGatewaySettings.model_validate(
            {"url": f"mqtt://127.0.0.1:{port}", "act": True, "client": client}
        )
        gateway = MqttGateway(gateway_node, settings)
        await tasks.start(gateway.serve)
        tasks.start_soon(follow)
        while len(levels) < count:
            await asyncio.sleep(0.05)
        await asyncio.sleep(1.0)  # what it does after the last lamp
        print(json.dumps({"known": len(levels)}), flush=True)
        spent = time.process_time()
        levels.clear()
        while list(levels.values()) != [LAST_LEVEL] * count:
            await asyncio.sleep(0.02)
        print(json.dumps({"cpu": time.process_time() - spent}), flush=True)
        tasks.cancel_scope.cancel()


configure_logging(level="error")
with short_collections():
    asyncio.run(main(int(sys.argv[1]), int(sys.argv[2]), sys.argv[3]))
