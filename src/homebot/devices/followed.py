"""What the reader of a live query has been told, and what it is to be told next. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from typing import final

from homebot.devices.device import Device, DeviceChange, Endpoint, Freshness, KeyValue

__all__ = ["FollowedDevices"]


@final
class FollowedDevices:
    """Turns what the directory says into what one reader hears, who may miss some of it or meet a new directory.

    To the reader, each device appears first, is removed last, and may then appear again; between the two come the other
    changes. A device that stops to offer the wanted service is removed.

    Args:
        service_type: The wanted service; empty for any.
    """

    def __init__(self, service_type: str) -> None:
        self._service_type = service_type
        self._known: dict[str, Device] = {}
        self._sequence = 0

    def take(self, change: DeviceChange) -> DeviceChange | None:
        """Return what the reader hears of *change*, or None when it is nothing to it."""
        if change.sequence <= self._sequence:
            return None
        device = change.device
        known = self._known.get(device.id)
        if change.kind == "removed" or not self._wants(device):
            if known is None:
                return None
            del self._known[device.id]
            return change if change.kind == "removed" else change.model_copy(update={"kind": "removed"})
        self._known[device.id] = device
        if known is None:
            return change if change.kind == "appeared" else change.model_copy(update={"kind": "appeared"})
        return change.model_copy(update={"kind": "changed"}) if change.kind == "appeared" else change

    def compare(self, devices: tuple[Device, ...], sequence: int) -> Iterator[DeviceChange]:
        """Yield how a snapshot differs from what the reader was told; changes up to *sequence* are old from now on."""
        self._sequence = sequence
        wanted = {device.id: device for device in devices if self._wants(device)}
        known, self._known = self._known, wanted
        for device_id, device in known.items():
            if device_id not in wanted:
                yield DeviceChange(
                    kind="removed", device=device, sequence=sequence, why="it went while the directory was away"
                )
        for device_id, device in wanted.items():
            before = known.get(device_id)
            if before is None:
                yield DeviceChange(kind="appeared", device=device, sequence=sequence, why="it was there already")
            elif _description(before) != _description(device):
                yield DeviceChange(
                    kind="changed", device=device, sequence=sequence, why="it changed while the directory was away"
                )

    def _wants(self, device: Device) -> bool:
        return not self._service_type or device.service_type == self._service_type


def _description(device: Device) -> tuple[str, str, tuple[Endpoint, ...], tuple[KeyValue, ...], Freshness]:
    return device.name, device.service_type, device.endpoints, device.metadata, device.freshness
