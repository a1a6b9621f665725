"""A simulated house without apps, and a node that looks on."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

import anyio
from tests.patience import PATIENCE

from homebot.config import parse_config
from homebot.devices import Device, Devices
from homebot.graph import Node
from homebot.house import World
from homebot.house.description import parse_world
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime


@asynccontextmanager
async def house(
    tables: Mapping[str, Mapping[str, object]], gateways: Mapping[str, object] | None = None
) -> AsyncIterator[tuple[Node, World]]:
    """A house with devices in its hall, and the node."""
    config = parse_config({"gateways": {"mqtt": {"act": True}, **(gateways or {})}}, "test")
    devices = {name: {"room": "hall", **table} for name, table in tables.items()}
    world = parse_world({"rooms": {"hall": {}}, "devices": devices}, "x")
    async with MemoryBroker() as broker:
        services = [HostedBroker.in_memory(broker)]
        async with (
            Runtime(config, house=world, with_door=False, services=services) as runtime,
            Node(runtime.graph, "onlooker") as node,
        ):
            yield node, world


async def found(node: Node, *names: str) -> dict[str, Device]:
    """Wait until devices with these names are found; return all."""
    with anyio.fail_after(PATIENCE):
        while True:
            devices = {one.name: one for one in await Devices(node).find()}
            if devices.keys() >= set(names):
                return devices
            await anyio.sleep(0.05)
