"""A directory, the gateway whose sightings and reports it hears, and a node that asks; in virtual time."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path

import anyio

from homebot.clock import Clock, LoopClock
from homebot.devices import FIND_DEVICES, Device, FindDevices, GatewayNames, Sighting
from homebot.devices.gateway_messages import Report
from homebot.devices.names import PLACE_DEVICE
from homebot.devices.places_messages import PlaceDevice, PlaceDeviceResponse
from homebot.discovery import Directory, DirectorySettings, OwnerFacts
from homebot.graph import DurabilityPolicy, Graph, Node, Publisher, QoSProfile


@dataclass
class House:
    """What a test uses of the house."""

    graph: Graph
    sightings: Publisher[Sighting]
    readings: Publisher[Report]
    directory: Directory
    asker: Node

    async def hears(self, *messages: Sighting | Report) -> None:
        for one in messages:
            if isinstance(one, Sighting):
                self.sightings.publish(one)
            else:
                self.readings.publish(one)
        await anyio.sleep(0.001)

    async def device(self, device_id: str) -> Device:
        found = await self.asker.create_client(FindDevices, FIND_DEVICES).call(FindDevices.Request())
        return next(one for one in found.devices if one.id == device_id)

    async def place(self, device: str, room: str, *, is_new: bool = False) -> PlaceDeviceResponse:
        client = self.asker.create_client(PlaceDevice, PLACE_DEVICE)
        return await client.call(PlaceDevice.Request(device=device, room=room, is_new=is_new))


@asynccontextmanager
async def directory(
    file: Path | None = None, owner: OwnerFacts | None = None, clock: Clock | None = None
) -> AsyncIterator[House]:
    """Run a directory, perhaps with an index *file* and the statements of its *owner*."""
    graph, names = Graph(clock or LoopClock(0.0)), GatewayNames("mqtt")
    kept = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    async with (
        Node(graph, "mqtt", namespace="/gateway") as gateway,
        Node(graph, "discovery") as node,
        Node(graph, "asker") as asker,
        anyio.create_task_group() as tasks,
    ):
        sightings = gateway.create_publisher(Sighting, names.received_topics, kept)
        directory = Directory(node, DirectorySettings(), file, owner)
        await tasks.start(directory.serve)
        readings = gateway.create_publisher(Report, names.readings, kept)
        yield House(graph, sightings, readings, directory, asker)
        tasks.cancel_scope.cancel()
