"""The watch of the devices with a place: phones and tags of people."""

from typing import final

import anyio

from homebot.devices.device import Device, DeviceChange, StateChange
from homebot.devices.house_view import HouseView, HouseWatcher
from homebot.gateways.people.whereabouts import PLACE, Sign, sign_of
from homebot.support.folding import fold

__all__ = ["TrackerWatch"]


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
        return [one.name for one in self._devices.values()]

    def signs(self, view: HouseView, name: str) -> dict[str, Sign]:
        """Return the sign of each tracker of the devices with the id or name *name*."""
        named = [
            one for one in self._devices.values() if one.id == name or fold(name) in map(fold, (one.name, *one.names))
        ]
        return {
            f"{device.id}#{part}": sign_of(device, known.state(part, PLACE), tag)
            for device in named
            if (known := view.get(device.id)) is not None
            for part, tag in _places(device)
        }


def _places(device: Device) -> list[tuple[str, str]]:
    """Return the ids and kinds of the parts with a place."""
    return [
        (one.id, one.part.tag)
        for one in device.parts
        if any(can.name == PLACE and can.readable for can in one.part.capabilities)
    ]
