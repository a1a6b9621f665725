"""The part of a device that a command or a lease is for. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.devices import Device, DevicePart
from homebot.devices.command_messages import CommandResult, Setting
from homebot.devices.command_results import result_of
from homebot.devices.outcomes import Gone

__all__ = ["commanded_part", "no_part_result"]


def commanded_part(device: Device, part_id: str, settings: Iterable[Setting]) -> DevicePart | None:
    """Return the part with the id *part_id*; without one, the only part that takes all *settings*.

    A part that is a setting is returned only if no other takes the same. None if there is no such part, or several.
    """
    part = device.part(part_id)
    if part is not None or part_id:
        return part
    wanted = {one.capability for one in settings}
    able = [one for one in device.parts if wanted <= {can.name for can in one.part.capabilities if can.settable}]
    found = [one for one in able if not one.part.category] or able
    return found[0] if len(found) == 1 else None


def no_part_result(device_id: str, part_id: str, device: Device | None, command_id: str = "") -> CommandResult:
    """Return the result of a command to a *device* that is None or has no such part.

    Whether it was removed or never there is not known; programs outside may spell an id in any way.
    """
    if device is None:
        text = f"there is no device with the id {device_id}"
    else:
        known = ", ".join(one.id for one in device.parts if one.id) or "one part without an id"
        text = f"{device_id} has no part {part_id or 'without an id'}; it has {known}"
    return result_of(Gone(command_id=command_id)).model_copy(update={"text": text})
