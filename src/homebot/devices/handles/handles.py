"""Factory of an application's handles."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING, TypeAlias, TypeVar
from weakref import WeakValueDictionary

from homebot.devices.device import Device, DeviceChange, StateChange
from homebot.devices.handles.tracked_device import TrackedDevice
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, DIRECTORY_NODE, FIND_DEVICES
from homebot.devices.query import query_terms
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.graph import Node

if TYPE_CHECKING:
    from homebot.devices.commander import Commander
    from homebot.devices.handles.handle import Handle
    from homebot.devices.handles.handle_query import HandleQuery

__all__ = ["Handles", "Watcher"]

HandleT = TypeVar("HandleT", bound="Handle")
Watcher: TypeAlias = Callable[[str, StateChange], None]
"""Called with the id of a device, and the new values of a message of it, or with an event."""


class Handles:
    """Makes the handles of one node, and keeps them up to date for as long as they are referenced.

    Args:
        node: The node; the handles are kept up to date until it ends.
    """

    def __init__(self, node: Node) -> None:
        self._node = node
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._tracked: WeakValueDictionary[str, TrackedDevice] = WeakValueDictionary()
        self._watchers: list[tuple[Watcher, Watcher]] = []
        node.create_subscription(DeviceChange, DEVICE_CHANGES, self._on_change, 1, from_node=DIRECTORY_NODE)
        node.create_subscription(StateChange, DEVICE_STATES, self._on_state, 1, from_node=DIRECTORY_NODE)

    @cached_property
    def commander(self) -> Commander:
        """The commander of the node, which gives their commands."""
        from homebot.devices.commander import Commander  # noqa: PLC0415 - many apps only watch

        return Commander(self._node)

    async def find(self, query: HandleQuery[HandleT]) -> tuple[HandleT, ...]:
        """Return the handles that match *query*, sorted by id.

        Raises:
            ServiceError: The directory does not answer.
        """
        answer = await self._find.call(FindDevicesRequest(query=query_terms(query.search)))
        found: list[HandleT] = []
        for device in answer.devices:
            if parts := query.parts(device):
                found += self.of_parts(query.kind, self.track(device, answer.sequence), parts)
        return tuple(found)

    def of_parts(self, kind: type[HandleT], device: TrackedDevice, parts: list[str]) -> list[HandleT]:
        """Return the handles of *parts* of a device."""
        return [kind(device, part, self) for part in parts]

    def track(self, device: Device, sequence: int, *, is_gone: bool = False) -> TrackedDevice:
        """Return the state that all handles of *device* share, updated with this description."""
        tracked = self._tracked.get(device.id)
        if tracked is None:
            tracked = self._tracked[device.id] = TrackedDevice(device, sequence, is_gone=is_gone)
        else:
            tracked.update(device, sequence, is_gone=is_gone)
        return tracked

    def watch(self, on_state: Watcher, on_event: Watcher) -> Callable[[], None]:
        """Call *on_state* with the new values of each device that has a handle, and *on_event* with every event.

        Returns:
            The function to stop.
        """
        watcher = on_state, on_event
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)

    def _on_change(self, change: DeviceChange) -> None:
        if (tracked := self._tracked.get(change.device.id)) is not None:
            tracked.update(change.device, change.sequence, is_gone=change.kind == "removed")

    def _on_state(self, change: StateChange) -> None:
        device_id = change.device
        if change.is_event:
            for _, on_event in self._watchers:
                on_event(device_id, change)
        elif (tracked := self._tracked.get(device_id)) is not None:
            tracked.take(change)
            for on_state, _ in self._watchers:
                on_state(device_id, change)
