"""The directory: the node that keeps the index, announces every change and answers who is there."""

from __future__ import annotations

import math

import anyio
from anyio.abc import TaskStatus
from pydantic import BaseModel, ConfigDict, Field

from homebot.devices import (
    DEVICE_CHANGES,
    FIND_DEVICES,
    GET_INDEX_DATA,
    DeviceChange,
    FindDevices,
    GetIndexData,
    Sighting,
)
from homebot.devices.services import (
    FindDevicesRequest,
    FindDevicesResponse,
    GetIndexDataRequest,
    GetIndexDataResponse,
)
from homebot.discovery.index import DeviceIndex
from homebot.graph import DurabilityPolicy, EndpointInfo, EntityKind, Node, QoSProfile, Subscription
from homebot.log import LogLimit
from homebot.units import Seconds

__all__ = ["Directory", "DirectorySettings"]

APPEARED = "discovery.appeared"
CHANGED = "discovery.changed"
STALE = "discovery.stale"
RETURNED = "discovery.returned"
REMOVED = "discovery.removed"
REJECTED = "discovery.index_full"

_SIGHTINGS_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class DirectorySettings(BaseModel):
    """The table ``[discovery]``.

    Attributes:
        forget_after: Seconds for which a stale device stays listed before it is removed; a day by default.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    forget_after: Seconds = Field(default=86_400.0)


class Directory:
    """Listens to the sightings of every gateway, present and to come.

    Args:
        node: The node that it is on the graph.
        settings: How long it remembers.

    Attributes:
        index: What it knows.
    """

    def __init__(self, node: Node, settings: DirectorySettings) -> None:
        self._node = node
        clock = node.graph.clock
        # Microseconds of the clock: a directory that was restarted goes on above the numbers of the one before.
        self.index = DeviceIndex(forget_after=settings.forget_after, first_sequence=round(clock.now() * 1e6) + 1)
        self._clock = clock
        self._changes = node.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        self._sources: dict[str, Subscription[Sighting]] = {}
        self._wakes_at = math.inf
        self._earlier_deadline = anyio.Event()
        self._limit = LogLimit(clock)
        node.create_service(GetIndexData, GET_INDEX_DATA, self._get_index_data)
        node.create_service(FindDevices, FIND_DEVICES, self._find_devices)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the index until cancelled."""
        with self._node.graph.watch() as changes:
            for endpoint in self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER):
                self._follow(endpoint)
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._expire)
                task_status.started()
                async for change in changes:
                    if change.change == "added":
                        self._follow(change.entity)

    def _follow(self, endpoint: EndpointInfo) -> None:
        is_source = endpoint.kind is EntityKind.PUBLISHER and endpoint.ros_type == Sighting.ros_type
        if is_source and endpoint.name not in self._sources:
            self._sources[endpoint.name] = self._node.create_subscription(
                Sighting, endpoint.name, self._observe, _SIGHTINGS_QOS
            )

    def _observe(self, sighting: Sighting) -> None:
        rejected = self.index.rejected
        change = self.index.observe(sighting)
        if change is not None:
            self._announce(change)
            if change.device.expires.to_seconds() < self._wakes_at:
                self._earlier_deadline.set()
        elif self.index.rejected > rejected and self._limit.allows(REJECTED) is not None:
            self._node.log.warning(
                REJECTED, message=f"{sighting.key} was not taken in: the index is full", rejected=self.index.rejected
            )

    async def _expire(self) -> None:
        while True:
            self._wakes_at = self.index.next_deadline() or math.inf
            self._earlier_deadline = anyio.Event()
            with anyio.move_on_after(max(0.0, self._wakes_at - self._clock.now())):
                await self._earlier_deadline.wait()
            for change in self.index.expire(self._clock.now()):
                self._announce(change)

    def _announce(self, change: DeviceChange) -> None:
        self._changes.publish(change)
        event, words = _WORDS[change.kind]
        device = change.device
        self._node.log.info(
            event,
            message=words.format(id=device.id, gateway=device.endpoints[0].gateway, why=change.why),
            device=device.id,
            service_type=device.service_type,
            gateway=device.endpoints[0].gateway,
            why=change.why,
        )

    def _get_index_data(self, request: GetIndexDataRequest) -> GetIndexDataResponse:
        devices = self.index.devices(request.service_type)
        return GetIndexDataResponse(
            topics=tuple(device.endpoints[0].address for device in devices),
            device_ids=tuple(device.id for device in devices),
        )

    def _find_devices(self, request: FindDevicesRequest) -> FindDevicesResponse:
        return FindDevicesResponse(devices=self.index.devices(request.service_type), sequence=self.index.sequence)


_WORDS = {
    "appeared": (APPEARED, "found {id} through {gateway}: {why}"),
    "changed": (CHANGED, "{id} changed: {why}"),
    "stale": (STALE, "{id} is stale: {why}"),
    "returned": (RETURNED, "{id} is back: {why}"),
    "removed": (REMOVED, "{id} is gone: {why}"),
}
