"""Devices in short, as screens and agents list them."""

from __future__ import annotations

from homebot.devices import Device
from homebot.devices.always_ask import waits_for_approval
from homebot.devices.services import ListedDevice
from homebot.devices.value import Reading
from homebot.discovery.description import position_of

__all__ = ["listed"]


def listed(device: Device, *, needs_approval: bool) -> ListedDevice:
    """Return *device* in short, without the values of its settings and diagnostics.

    Args:
        needs_approval: Whether a device that can hurt waits for the owner's approval.
    """
    position = position_of(device.facts)
    used = {one.id for one in device.parts if not one.part.category}
    return ListedDevice(
        id=device.id,
        name=device.name,
        type=(device.service_types or (device.service_type,))[0],
        room=device.area,
        freshness=device.freshness,
        is_reachable=device.reachable.state != "no",
        waits=needs_approval and waits_for_approval(device),
        states=tuple(
            Reading(part=one.part, capability=one.capability, value=one.value)
            for one in device.states
            if one.part in used
        ),
        position=() if position is None else (position.x, position.y),
    )
