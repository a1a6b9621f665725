"""The floor of a simulated house: its rooms, doors and devices as a table ``[places]``, and as a map of ROS. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Final

from homebot.house.rooms import OUTSIDE, Rooms
from homebot.house.simulated_device import Placed
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Point, Pose, Quaternion
from homebot.messages.nav_msgs import MapMetaData, OccupancyGrid
from homebot.messages.std_msgs.header import Header

__all__ = ["occupancy_grid", "places_table"]

_CELL: Final = 0.05
_DOOR: Final = 0.9
"""Metres of a cell of the map, and of the width of a door."""

_FREE, _OCCUPIED, _UNKNOWN = 0, 100, 255


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
        door: dict[str, object] = {"rooms": [one, other], "position": list(middle), "width": _DOOR}
        for kind in ("contact", "lock"):
            if (device := contacts.get((frozenset({one, other}), kind))) is not None:
                door[kind] = device
        doors.append(door)
    placed = {name: {"at": list(one.at)} for name, one in devices.items() if one.at is not None}
    return {"rooms": found, "doors": doors, "devices": placed} if found else {}


def occupancy_grid(rooms: Rooms, stamp: Time) -> OccupancyGrid:
    """Return the map: rooms are free, their walls occupied but for the doors, and all else is unknown."""
    corners = [corner for room in rooms.rooms.values() for corner in room.corners]
    left, bottom = min(x for x, _ in corners), min(y for _, y in corners)
    width = math.ceil((max(x for x, _ in corners) - left) / _CELL) + 1
    height = math.ceil((max(y for _, y in corners) - bottom) / _CELL) + 1
    cells = bytearray([_UNKNOWN]) * (width * height)

    def fill(x1: float, y1: float, x2: float, y2: float, value: int) -> None:
        first, last = round((x1 - left) / _CELL), round((x2 - left) / _CELL) + 1
        for row in range(round((y1 - bottom) / _CELL), round((y2 - bottom) / _CELL) + 1):
            cells[row * width + first : row * width + last] = bytes([value]) * (last - first)

    for x1, y1, x2, y2 in _boxes(rooms):
        fill(x1, y1, x2, y2, _OCCUPIED)
    for x1, y1, x2, y2 in _boxes(rooms):
        fill(x1 + _CELL, y1 + _CELL, x2 - _CELL, y2 - _CELL, _FREE)
    for one, other, (x, y) in rooms.doorways():
        (left1, bottom1), (right1, top1) = rooms.rooms[one].corners[0], rooms.rooms[one].corners[2]
        is_upright = x in {left1, right1} and bottom1 < y < top1 and other != OUTSIDE
        dx, dy = (_CELL, _DOOR / 2) if is_upright else (_DOOR / 2, _CELL)
        fill(x - dx, y - dy, x + dx, y + dy, _FREE)
    origin = Pose(position=Point(x=left - _CELL / 2, y=bottom - _CELL / 2, z=0.0), orientation=Quaternion(w=1.0))
    info = MapMetaData(map_load_time=stamp, resolution=_CELL, width=width, height=height, origin=origin)
    signed = tuple(value - 256 if value == _UNKNOWN else value for value in cells)
    return OccupancyGrid(header=Header(stamp=stamp, frame_id="map"), info=info, data=signed)


def _boxes(rooms: Rooms) -> Iterator[tuple[float, float, float, float]]:
    for room in rooms.rooms.values():
        if room.corners:
            yield (*room.corners[0], *room.corners[2])
