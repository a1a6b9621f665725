"""The directory: the node that keeps the index, announces every change and answers who is there."""

from __future__ import annotations

import math

import anyio
import anyio.lowlevel
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
from homebot.discovery.index import MAX_DEVICES, DeviceIndex
from homebot.errors import TypeMismatchError
from homebot.graph import DurabilityPolicy, EntityKind, Node, QoSProfile, Subscription
from homebot.log import LogLimit
from homebot.units import Seconds

__all__ = ["Directory", "DirectorySettings"]

APPEARED = "discovery.appeared"
CHANGED = "discovery.changed"
STALE = "discovery.stale"
RETURNED = "discovery.returned"
REMOVED = "discovery.removed"
REJECTED = "discovery.index_full"
NOT_FOLLOWED = "discovery.source_not_followed"

BURST = 50
"""Lines of each kind of change in ten seconds; a flood of devices is counted rather than told."""

LONGEST_SLEEP = 60.0
"""Seconds after which deadlines are looked at anew: the computer's clock may have been set meanwhile."""

_TURN = 100
"""Changes made in one go before other tasks get their turn."""

_SIGHTINGS_QOS = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class DirectorySettings(BaseModel):
    """The table ``[discovery]``.

    Attributes:
        forget_after: Seconds for which a stale device stays listed before it is removed; a day by default.
        max_devices: How many devices are listed; further ones are counted and told.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    forget_after: Seconds = Field(default=86_400.0)
    max_devices: int = Field(default=MAX_DEVICES, ge=1)


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
        self.index = DeviceIndex(
            forget_after=settings.forget_after,
            first_sequence=round(clock.now() * 1e6) + 1,
            max_devices=settings.max_devices,
        )
        self._clock = clock
        self._changes = node.create_publisher(DeviceChange, DEVICE_CHANGES, 10)
        self._sources: dict[str, Subscription[Sighting]] = {}
        self._wakes_at = math.inf
        self._earlier_deadline = anyio.Event()
        self._limit = LogLimit(clock)
        self._told = LogLimit(clock, burst=BURST)

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        """Keep the index until cancelled.

        It answers as soon as it has taken in what the gateways keep for late joiners, so that nobody who asks a
        restarted directory hears of an empty house.
        """
        with self._node.graph.watch() as changes:
            self._follow_all()
            self._node.create_service(GetIndexData, GET_INDEX_DATA, self._get_index_data)
            self._node.create_service(FindDevices, FIND_DEVICES, self._find_devices)
            async with anyio.create_task_group() as tasks:
                tasks.start_soon(self._expire)
                task_status.started()
                lost = 0
                async for change in changes:
                    if changes.lost > lost:
                        lost = changes.lost
                        while changes.take() is not None:
                            pass
                        self._follow_all()
                    elif change.change == "added" and change.entity.ros_type == Sighting.ros_type:
                        self._follow(change.entity.name)

    def _follow_all(self) -> None:
        for endpoint in self._node.graph.get_endpoints(kind=EntityKind.PUBLISHER):
            if endpoint.ros_type == Sighting.ros_type:
                self._follow(endpoint.name)

    def _follow(self, topic: str) -> None:
        if topic in self._sources:
            return
        try:
            source = self._node.create_subscription(Sighting, topic, qos_profile=_SIGHTINGS_QOS)
        except TypeMismatchError as exc:
            self._node.log.warning(NOT_FOLLOWED, message=str(exc), topic=topic)
            return
        self._sources[topic] = source
        while (kept := source.take()) is not None:
            self._observe(kept)
        self._node.create_task(lambda: source.run(self._observe, concurrent=False))

    def _observe(self, sighting: Sighting) -> None:
        rejected = self.index.rejected
        change = self.index.observe(sighting)
        if change is not None:
            self._announce(change)
        elif self.index.rejected > rejected and self._limit.allows(REJECTED) is not None:
            self._node.log.warning(
                REJECTED, message=f"{sighting.key} was not taken in: the index is full", rejected=self.index.rejected
            )
        if sighting.expires_at.to_seconds() < self._wakes_at:
            self._earlier_deadline.set()

    async def _expire(self) -> None:
        while True:
            self._wakes_at = self.index.next_deadline() or math.inf
            self._earlier_deadline = anyio.Event()
            delay = min(self._wakes_at - self._clock.now(), LONGEST_SLEEP) if self._wakes_at < math.inf else math.inf
            with anyio.move_on_after(max(0.0, delay)):
                await self._earlier_deadline.wait()
            while changes := self.index.expire(self._clock.now(), at_most=_TURN):
                for change in changes:
                    self._announce(change)
                await anyio.lowlevel.checkpoint()

    def _announce(self, change: DeviceChange) -> None:
        self._changes.publish(change)
        event, words = _WORDS[change.kind]
        held_back = self._told.allows(event)
        if held_back is None:
            return
        device = change.device
        more = f" (and {held_back} more like this)" if held_back else ""
        self._node.log.info(
            event,
            message=words.format(id=device.id, gateway=device.endpoints[0].gateway, why=change.why) + more,
            device=device.id,
            service_type=device.service_type,
            gateway=device.endpoints[0].gateway,
            why=change.why,
            held_back=held_back,
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
