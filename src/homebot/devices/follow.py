"""A live query: the devices of a type that are there, and then whatever happens to them."""

from __future__ import annotations

from collections import deque
from typing import Self

from homebot.devices.device import DeviceChange
from homebot.devices.names import DEVICE_CHANGES, FIND_DEVICES
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.graph import Node, Subscription

__all__ = ["Follow"]


class Follow:
    """``async for change in Follow(node, "lights")``: first ``appeared`` for each device there is, then every change.

    A reader that falls behind misses intermediate changes of a device, never its last one.

    Args:
        node: Who asks; the query ends with it.
        service_type: For example ``lights``; empty for every device.
    """

    def __init__(self, node: Node, service_type: str = "") -> None:
        self._node = node
        self._service_type = service_type
        self._changes: Subscription[DeviceChange] | None = None
        self._snapshot: deque[DeviceChange] = deque()
        self._sequence = 0

    def __aiter__(self) -> Self:
        return self

    async def __anext__(self) -> DeviceChange:
        if self._changes is None:
            self._changes = await self._begin()
        if self._snapshot:
            return self._snapshot.popleft()
        async for change in self._changes:
            if change.sequence > self._sequence and self._wants(change):
                return change
        raise StopAsyncIteration

    def close(self) -> None:
        """End the query. Twice is fine."""
        if self._changes is not None:
            self._changes.close()

    async def _begin(self) -> Subscription[DeviceChange]:
        """Subscribe first and ask then: no change can fall between, and the sequence tells what is in the answer."""
        changes = self._node.create_subscription(DeviceChange, DEVICE_CHANGES, qos_profile=1)
        client = self._node.create_client(FindDevices, FIND_DEVICES)
        await client.wait_for_service()
        found = await client.call(FindDevicesRequest(service_type=self._service_type))
        client.close()
        self._sequence = found.sequence
        self._snapshot.extend(
            DeviceChange(kind="appeared", device=device, sequence=found.sequence, why="it was there already")
            for device in found.devices
        )
        return changes

    def _wants(self, change: DeviceChange) -> bool:
        return not self._service_type or change.device.service_type == self._service_type
