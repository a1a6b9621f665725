"""Rooms that a tag or a code says, which nobody has confirmed. Pure."""

from __future__ import annotations

from homebot.devices.device import Device
from homebot.devices.names import TAG

__all__ = ["without_taught_room"]


def without_taught_room(device: Device) -> Device:
    """Return *device* without its room, where only a tag or a code says it; otherwise the same device.

    Whoever can put up a tag can say a room, so it gives nobody a right. A room that the owner states, in the
    configuration or by a command, and one that the device announces of itself are not touched.
    """
    conventions = {one.convention for one in device.facts if one.name == "area"} if device.area else set()
    return device.with_checked(area="", outer_areas=()) if conventions == {TAG} else device
