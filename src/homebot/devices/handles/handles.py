"""Factory of an application's handles."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar
from weakref import WeakValueDictionary

from homebot.devices.capabilities import EVENTS
from homebot.devices.device import Device, DeviceChange, StateChange
from homebot.devices.handles.command_sender import CommandSender
from homebot.devices.handles.handle import Handle
from homebot.devices.handles.handle_query import HandleQuery
from homebot.devices.handles.tracked_device import TrackedDevice
from homebot.devices.names import DEVICE_CHANGES, DEVICE_STATES, DIRECTORY_NODE, FIND_DEVICES
from homebot.devices.query import query_terms
from homebot.devices.services import FindDevices, FindDevicesRequest
from homebot.graph import Node

__all__ = ["Handles", "Watcher"]

HandleT = TypeVar("HandleT", bound=Handle)
Watcher = Callable[[StateChange], None]
"""Is told what devices tell."""


class Handles:
    """Makes the handles of one node, and keeps them up to date for as long as somebody holds them.

    Args:
        node: Whose they are; they are kept up to date until it ends.
    """

    def __init__(self, node: Node) -> None:
        self._commander = CommandSender(node)
        self._find = node.create_client(FindDevices, FIND_DEVICES)
        self._known: WeakValueDictionary[str, TrackedDevice] = WeakValueDictionary()
        self._watchers: list[Watcher] = []
        node.create_subscription(DeviceChange, DEVICE_CHANGES, self._on_change, 1, from_node=DIRECTORY_NODE)
        node.create_subscription(StateChange, DEVICE_STATES, self._on_state, 1, from_node=DIRECTORY_NODE)

    async def find(self, wanted: HandleQuery[HandleT]) -> tuple[HandleT, ...]:
        """Return the handles that are *wanted*, sorted by id.

        Raises:
            ServiceError: The directory does not answer.
        """
        answer = await self._find.call(FindDevicesRequest(query=query_terms(wanted.device_query())))
        return tuple(
            self.handle(wanted, self.known(device, answer.sequence), part)
            for device in answer.devices
            for part in wanted.parts(device)
        )

    def handle(self, wanted: HandleQuery[HandleT], known: TrackedDevice, part: str) -> HandleT:
        """Return the handle of a part."""
        return wanted.kind(known, part, self._commander)

    def known(self, device: Device, sequence: int, *, is_gone: bool = False) -> TrackedDevice:
        """Return what all handles of *device* share, after it has taken this description of it."""
        known = self._known.get(device.id)
        if known is None:
            known = self._known[device.id] = TrackedDevice(device, sequence, is_gone=is_gone)
        else:
            known.take(device, sequence, is_gone=is_gone)
        return known

    def watch(self, watcher: Watcher) -> Callable[[], None]:
        """Call *watcher* whenever a device tells something that somebody holds a handle of; return how to end that."""
        self._watchers.append(watcher)
        return lambda: self._watchers.remove(watcher)

    def _on_change(self, change: DeviceChange) -> None:
        if (known := self._known.get(change.device.id)) is not None:
            known.take(change.device, change.sequence, is_gone=change.kind == "removed")

    def _on_state(self, change: StateChange) -> None:
        known = self._known.get(change.device)
        if known is not None:
            known.take_state(change)
        if known is not None or change.state.capability in EVENTS:
            for watcher in self._watchers:
                watcher(change)
