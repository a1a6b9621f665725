"""The place of a device in a house, and the commands that timers give it every day."""

from __future__ import annotations

from typing import NamedTuple

from homebot.house.simulated_device import SimulatedDevice

__all__ = ["Placed", "ScheduledCommand"]


class Placed(NamedTuple):
    """A device in its place.

    Attributes:
        device: The device, with its faults.
        room: Where it is.
        door: For a contact or a lock: the room on the other side of the door it is on.
        dialect: Its family where it is carried over a wire, by name.
    """

    device: SimulatedDevice
    room: str
    door: str = ""
    dialect: str = "thesis"


class ScheduledCommand(NamedTuple):
    """A command that a timer gives every day.

    Attributes:
        at: Seconds since midnight.
        device_id: The device.
        command: What.
    """

    at: float
    device_id: str
    command: str
