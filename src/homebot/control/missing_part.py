"""The result of a command to a part that is not in the house. Pure."""

from __future__ import annotations

from homebot.devices import Device
from homebot.devices.command_messages import CommandResult
from homebot.devices.command_results import result_of
from homebot.devices.outcomes import Gone

__all__ = ["missing_part"]


def missing_part(device_id: str, part_id: str, device: Device | None, command_id: str = "") -> CommandResult:
    """Return the result of a command, or a wish to hold, whose *device* is None or has no such part.

    Whether it was removed or never there is not known; programs outside may spell an id in any way.
    """
    if device is None:
        text = f"there is no device with the id {device_id}"
    else:
        known = ", ".join(one.id for one in device.parts if one.id) or "one part without an id"
        text = f"{device_id} has no part {part_id or 'without an id'}; it has {known}"
    return result_of(Gone(command_id=command_id)).with_checked(text=text)
