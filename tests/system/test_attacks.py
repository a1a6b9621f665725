"""Attacks by programs and devices that may speak to homebot, done for real over sockets."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
from tests.patience import PATIENCE
from websockets.asyncio.client import connect

from homebot.config import parse_config
from homebot.devices import Devices, Sighting
from homebot.graph import Node
from homebot.house import thesis_world
from homebot.messages import Time
from homebot.messages.json import message_to_json
from homebot.runtime import Runtime

pytestmark = pytest.mark.system

NOW = Time(sec=2_000_000_000, nanosec=0)
HOUSE = {
    "gateways": {"mqtt": {"root": "home425"}},
    "apps": {"light_service": {}},
    "door": {"port": 0},
}


@asynccontextmanager
async def running(index_file: Path) -> AsyncIterator[Runtime]:
    """The thesis's house, with its light service and its door."""
    config = parse_config(HOUSE, "test")
    async with Runtime(config, house=thesis_world(), index_file=index_file) as runtime:
        yield runtime


async def forge(runtime: Runtime, topic: str, sighting: dict[str, Any]) -> None:
    """Publish a sighting through the door, and wait until it was dealt with."""
    assert runtime.door is not None
    async with connect(f"ws://127.0.0.1:{runtime.door.port}/", proxy=None, compression=None) as client:
        frames = (
            {"op": "advertise", "topic": topic, "type": Sighting.ros_type},
            {"op": "publish", "topic": topic, "msg": sighting},
            {"op": "call_service", "id": "end", "service": "/rosapi/get_time", "args": {}},
        )
        for frame in frames:
            await client.send(json.dumps(frame))
        with anyio.fail_after(PATIENCE):
            while json.loads(await client.recv()).get("id") != "end":
                pass


async def known(runtime: Runtime, device: str) -> None:
    """Wait until *device* is there."""
    async with Node(runtime.graph, "watcher") as node:
        with anyio.fail_after(PATIENCE):
            async for change in Devices(node).follow():
                if change.device.id == device:
                    return


async def ids(runtime: Runtime) -> set[str]:
    assert runtime.door is not None
    async with connect(f"ws://127.0.0.1:{runtime.door.port}/", proxy=None, compression=None) as client:
        await client.send(
            json.dumps({"op": "call_service", "id": "f", "service": "/discovery/find_devices", "args": {}})
        )
        with anyio.fail_after(PATIENCE):
            while (frame := json.loads(await client.recv())).get("id") != "f":
                pass
    return {device["id"] for device in frame["values"]["devices"]}


@pytest.mark.parametrize(
    "topic", ["/gateway/mqtt/received_topics", "/gateway/x/received_topics", "/anything"], ids=["own", "new", "other"]
)
async def test_a_frame_at_the_door_makes_no_device_and_ends_no_app(tmp_path: Path, topic: str) -> None:
    """Nor after a restart, with what the index file kept."""
    index_file = tmp_path / "index.sqlite"
    forged = Sighting(
        gateway="no gateway!",
        key="lights/forged",
        kind="appeared",
        why="",
        name="forged",
        service_type="lights",
        address="x",
        command_address="x",
        seen_at=NOW,
        expires_at=NOW,
        confirmed=True,
    )
    for _ in range(2):
        async with running(index_file) as runtime:
            await known(runtime, "lights/philips165")
            await forge(runtime, topic, message_to_json(forged))
            await anyio.sleep(0.2)
            assert not any("forged" in one for one in await ids(runtime))
            assert not runtime.supervisor.given_up
            assert not runtime.supervisor.restarts
            assert runtime.graph.get_node("/light_service") is not None
