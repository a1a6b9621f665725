"""The floor of a simulated house, its rooms, doors and devices, as a table ``[places]``. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from homebot.house.rooms import Rooms
from homebot.house.simulated_device import Placed

__all__ = ["DOOR_WIDTH", "places_table"]

DOOR_WIDTH: Final = 0.9
"""Metres of the width of a door."""


def places_table(rooms: Rooms, devices: Mapping[str, Placed]) -> dict[str, object]:
    """Return the table ``[places]``: each room with an extent, the doors between them, and devices with a position."""
    found = {
        name: {"polygon": [list(corner) for corner in room.corners]}
        for name, room in rooms.rooms.items()
        if room.corners
    }
    contacts = {(frozenset({one.room, one.door}), one.device.kind): name for name, one in devices.items() if one.door}
    doors = []
    for one, other, middle in rooms.doorways():
        door: dict[str, object] = {"rooms": [one, other], "position": list(middle), "width": DOOR_WIDTH}
        for kind in ("contact", "lock"):
            if (device := contacts.get((frozenset({one, other}), kind))) is not None:
                door[kind] = _id(device, devices[device])
        doors.append(door)
    placed = {_id(name, one): {"at": list(one.at)} for name, one in devices.items() if one.at is not None}
    return {"rooms": found, "doors": doors, "devices": placed} if found else {}


def _id(name: str, placed: Placed) -> str:
    """Return the id that the directory gives to a device."""
    return f"{placed.device.service_type}/{name}" if placed.dialect == "thesis" else name
