"""The index: who is out there, what they offer, and how fresh that knowledge is. Pure; the time comes from outside.

It holds devices, not topics: however many messages and addresses a device has, it is one entry.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

from homebot.devices import Device, DeviceChange, Endpoint, Freshness, KeyValue, Sighting
from homebot.discovery.deadlines import Deadlines
from homebot.messages import Time

__all__ = ["MAX_DEVICES", "DeviceIndex"]

MAX_DEVICES = 100_000


class DeviceIndex:
    """Every known device, kept up to date by sightings and the passing of time.

    Args:
        forget_after: Seconds for which a stale device stays in the index before it is removed.
        first_sequence: Number of the first change; a new index that follows an old one starts above it.
        max_devices: How many it takes in.

    Attributes:
        sequence: Number of the last change.
        rejected: Sightings of new devices that were not taken because the index was full.
    """

    def __init__(self, *, forget_after: float, first_sequence: int = 1, max_devices: int = MAX_DEVICES) -> None:
        self.sequence = first_sequence - 1
        self.rejected = 0
        self._forget_after = forget_after
        self._max_devices = max_devices
        self._entries: dict[str, _Entry] = {}
        self._ids: dict[tuple[str, str], str] = {}
        self._deadlines = Deadlines()

    def observe(self, sighting: Sighting) -> DeviceChange | None:
        """Take *sighting* in and return what it changes; None for one that only says "still there"."""
        device_id = self._ids.get((sighting.gateway, sighting.key))
        if sighting.kind == "removed":
            return self._remove(device_id, sighting.why) if device_id is not None else None
        if device_id is None:
            return self._add(sighting)
        return self._refresh(self._entries[device_id], sighting)

    def expire(self, now: float, at_most: int | None = None) -> tuple[DeviceChange, ...]:
        """Return what the passing of time changes: devices that become stale at *now*, and those to be forgotten.

        Args:
            now: Seconds since the Unix epoch.
            at_most: How many changes to make; ask again until none is left. None makes them all.
        """
        changes: list[DeviceChange] = []
        while (at_most is None or len(changes) < at_most) and (due := self._deadlines.pop(now)) is not None:
            entry = self._entries[due]
            if entry.freshness == "stale":
                changes.append(self._remove(due, "it has been stale for too long"))
            else:
                entry.become_stale()
                self._plan(entry)
                changes.append(self._change("stale", entry, "it has been silent for too long"))
        return tuple(changes)

    def next_deadline(self) -> float | None:
        """Return when :meth:`expire` has something to do, in seconds since the Unix epoch; None for never."""
        return self._deadlines.next()

    def devices(self, service_type: str = "") -> tuple[Device, ...]:
        """Return the devices that offer *service_type* (all of them when it is empty), sorted by id."""
        return tuple(
            entry.to_device()
            for _, entry in sorted(self._entries.items())
            if not service_type or entry.sighting.service_type == service_type
        )

    def get(self, device_id: str) -> Device | None:
        """Return the device *device_id*, or None."""
        entry = self._entries.get(device_id)
        return entry.to_device() if entry else None

    def __len__(self) -> int:
        return len(self._entries)

    def _add(self, sighting: Sighting) -> DeviceChange | None:
        if len(self._entries) >= self._max_devices:
            self.rejected += 1
            return None
        device_id = self._free_id(sighting)
        self._ids[sighting.gateway, sighting.key] = device_id
        entry = self._entries[device_id] = _Entry(device_id, sighting)
        self._plan(entry)
        return self._change("appeared", entry, sighting.why)

    def _plan(self, entry: _Entry) -> None:
        forgets = self._forget_after if entry.freshness == "stale" else 0.0
        self._deadlines.set(entry.device_id, entry.expires.to_seconds() + forgets)

    def _free_id(self, sighting: Sighting) -> str:
        """A key is the id, unless another gateway has a device of the same key."""
        device_id = sighting.key
        while device_id in self._entries:
            device_id = f"{device_id}@{sighting.gateway}"
        return device_id

    def _refresh(self, entry: _Entry, sighting: Sighting) -> DeviceChange | None:
        was, was_described = entry.freshness, _description(entry.sighting)
        entry.refresh(sighting)
        self._plan(entry)
        if was == "stale" and entry.freshness == "fresh":
            return self._change("returned", entry, "it spoke again")
        if was_described != _description(sighting):
            return self._change("changed", entry, "it is described anew")
        if was != entry.freshness:
            return self._change("changed", entry, "it spoke itself")
        return None

    def _remove(self, device_id: str, why: str) -> DeviceChange:
        entry = self._entries.pop(device_id)
        self._deadlines.discard(device_id)
        del self._ids[entry.sighting.gateway, entry.sighting.key]
        return self._change("removed", entry, why)

    def _change(
        self, kind: Literal["appeared", "changed", "stale", "returned", "removed"], entry: _Entry, why: str
    ) -> DeviceChange:
        self.sequence += 1
        return DeviceChange(kind=kind, device=entry.to_device(), sequence=self.sequence, why=why)


@dataclass(slots=True)
class _Entry:
    device_id: str
    sighting: Sighting
    first_seen: Time = field(init=False)
    expires: Time = field(init=False)
    freshness: Freshness = field(init=False)
    _device: Device | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        self.first_seen = self.sighting.seen_at
        self.expires = self.sighting.expires_at
        self.freshness = "fresh" if self.sighting.confirmed else "unconfirmed"

    def refresh(self, sighting: Sighting) -> None:
        """A kept message tells nothing new of a device that has spoken itself."""
        self._device = None
        if not sighting.confirmed and self.freshness != "unconfirmed":
            self.sighting = sighting.model_copy(update={"seen_at": self.sighting.seen_at, "confirmed": True})
            return
        self.sighting = sighting
        self.expires = sighting.expires_at
        self.freshness = "fresh" if sighting.confirmed else "unconfirmed"

    def become_stale(self) -> None:
        self._device = None
        self.freshness = "stale"

    def to_device(self) -> Device:
        """The same object as long as nothing is new: an answer may hold thousands of them."""
        if self._device is None:
            self._device = self._to_device()
        return self._device

    def _to_device(self) -> Device:
        sighting = self.sighting
        endpoint = Endpoint(
            gateway=sighting.gateway,
            key=sighting.key,
            address=sighting.address,
            command_address=sighting.command_address,
        )
        return Device(
            id=self.device_id,
            name=sighting.name,
            service_type=sighting.service_type,
            endpoints=(endpoint,),
            metadata=sighting.metadata,
            first_seen=self.first_seen,
            last_seen=sighting.seen_at,
            expires=self.expires,
            freshness=self.freshness,
        )


def _description(sighting: Sighting) -> tuple[str, str, str, str, tuple[KeyValue, ...]]:
    return (
        sighting.name,
        sighting.service_type,
        sighting.address,
        sighting.command_address,
        sighting.metadata,
    )
