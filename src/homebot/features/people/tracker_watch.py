"""The watch of the devices with a place: phones and tags of people."""

from collections.abc import Mapping
from contextlib import suppress
from typing import final

import anyio

from homebot.devices.device import Device, DeviceChange, DevicePart, StateChange
from homebot.devices.device_lookup import references
from homebot.devices.device_names import devices_called, names_of
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.devices.query.terms import TypeIs
from homebot.errors import ServiceError
from homebot.features.people.settings import PersonSettings
from homebot.features.people.whereabouts import PLACE, Sign, sign_of
from homebot.support.folding import fold


@final
class TrackerWatch(HouseWatcher):
    """The devices with a place.

    Attributes:
        changed: Set when one of them changed.
    """

    def __init__(self) -> None:
        self.changed = anyio.Event()
        self._devices: dict[str, Device] = {}

    def on_device(self, change: DeviceChange) -> None:
        """See :class:`HouseWatcher`."""
        device = change.device
        if change.kind != "removed" and _places(device):
            self._devices[device.id] = device
            self.changed.set()
        elif self._devices.pop(device.id, None) is not None:
            self.changed.set()

    def on_values(self, change: StateChange) -> None:
        """See :class:`HouseWatcher`."""
        if change.device in self._devices:
            self.changed.set()

    @property
    def names(self) -> list[str]:
        """The names of all."""
        return [device.name for device in self._devices.values()]

    async def catch_up(self, view: HouseView) -> bool:
        """Read the devices again that have reported, but whose places are kept ones: an equal place is no change.

        Returns:
            Whether there are any.
        """
        lags = any(
            device.freshness == "fresh" and state is not None and not state.live
            for device in self._devices.values()
            if (known := view.get(device.id)) is not None
            for state in (known.state(part, PLACE) for part, _ in _places(device))
        )
        if lags:
            with suppress(ServiceError):
                trackers = await view.find(TypeIs("tracker", frozenset({"x_tracker"}), by_word=False))
                for tracker in trackers.devices:
                    view.store(tracker, trackers.sequence)
        return lags

    def persons(self, people: Mapping[str, PersonSettings]) -> dict[str, str]:
        """Return the names, by id, of the persons in other systems that have trackers.

        A person with the name or a tracker of one of *people* is left out, and so is one that is a tracker there.
        """
        names = {*map(fold, people)}
        known = self._devices.values()
        taken = [
            tracker for person in people.values() for text in person.trackers for tracker in devices_called(text, known)
        ]
        return {
            device.id: device.name
            for device in self._devices.values()
            if device.freshness != "stale" or device.reachable.state == "no"  # else its system has it no more
            for part in device.parts
            if part.part.members and part.part.service_type == "x_tracker"  # no announcement over MQTT can have both
            if names.isdisjoint(map(fold, names_of(device)))
            if not any(_is_of(tracker, device, part) for tracker in taken)
        }

    def signs(self, view: HouseView, name: str) -> dict[str, Sign]:
        """Return the sign of each tracker of the device with the id *name*, or else of those with that name."""
        return {
            f"{device.id}#{part}": sign_of(device, known.state(part, PLACE), tag)
            for device in devices_called(name, self._devices.values())
            if (known := view.get(device.id)) is not None
            for part, tag in _places(device)
        }


def _is_of(tracker: Device, person: Device, part: DevicePart) -> bool:
    """Return whether *tracker* is the person, or a tracker of the person."""
    gateways = {route.gateway for route in part.routes}
    known = (name for own_part in tracker.parts for name in references(tracker, own_part, gateways))
    return tracker.id == person.id or not {*known}.isdisjoint(part.part.members)


def _places(device: Device) -> list[tuple[str, str]]:
    """Return the ids and kinds of the parts with a place."""
    return [
        (part.id, part.part.tag)
        for part in device.parts
        if any(can.name == PLACE and can.readable for can in part.part.capabilities)
    ]
