"""Names for people of devices and of their parts. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.devices.device import Device
from homebot.devices.part import Part

__all__ = ["part_names"]


def part_names(devices: Iterable[Device]) -> dict[str, str]:
    """Return the names of *devices* by their ids, and those of their parts by ``ID#PART``.

    Parts are named only where several of them take commands, settings aside; else the name of the device tells enough.
    """
    names: dict[str, str] = {}
    for device in devices:
        names[device.id] = device.name
        parts = [one for one in device.parts if _is_commanded(one.part)]
        if len(parts) > 1:
            names |= {f"{device.id}#{one.id}": f"{device.name} {one.part.name or one.id}".rstrip() for one in parts}
    return names


def _is_commanded(part: Part) -> bool:
    return not part.category and any(one.settable for one in part.capabilities)
