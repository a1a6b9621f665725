"""The part of a device that a command, or a wish to hold, is for. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.devices import Device, DevicePart
from homebot.devices.command_messages import Setting

__all__ = ["meant_part"]


def meant_part(device: Device, part_id: str, settings: Iterable[Setting]) -> DevicePart | None:
    """Return the part with the id *part_id*; without one, the only part that takes all *settings*.

    A part that is a setting is meant only where no other takes the same. None where there is no such part, or several.
    """
    part = device.part(part_id)
    if part is not None or part_id:
        return part
    wanted = {one.capability for one in settings}
    able = [one for one in device.parts if wanted <= {can.name for can in one.part.capabilities if can.settable}]
    found = [one for one in able if not one.part.category] or able
    return found[0] if len(found) == 1 else None
