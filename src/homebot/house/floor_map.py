"""The floor of a simulated house as a map of ROS. Pure."""

from __future__ import annotations

import math
from array import array
from collections.abc import Iterator
from typing import Final

from homebot.house.rooms import DOOR_WIDTH, OUTSIDE, Rooms
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Point, Pose, Quaternion
from homebot.messages.nav_msgs import MapMetaData, OccupancyGrid
from homebot.messages.std_msgs.header import Header

__all__ = ["occupancy_grid"]

_CELL: Final = 0.05
"""Metres."""

_FREE, _OCCUPIED, _UNKNOWN = 0, 100, 255


def occupancy_grid(rooms: Rooms, stamp: Time) -> OccupancyGrid:
    """Return the map: rooms are free, their walls occupied but for the doors, and all else is unknown."""
    xs, ys = zip(*(corner for room in rooms.rooms.values() for corner in room.corners), strict=True)
    left, bottom = min(xs), min(ys)
    width = math.ceil((max(xs) - left) / _CELL) + 1
    height = math.ceil((max(ys) - bottom) / _CELL) + 1
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
        dx, dy = (_CELL, DOOR_WIDTH / 2) if is_upright else (DOOR_WIDTH / 2, _CELL)
        fill(x - dx, y - dy, x + dx, y + dy, _FREE)
    origin = Pose(position=Point(x=left - _CELL / 2, y=bottom - _CELL / 2, z=0.0), orientation=Quaternion(w=1.0))
    info = MapMetaData(map_load_time=stamp, resolution=_CELL, width=width, height=height, origin=origin)
    return OccupancyGrid(header=Header(stamp=stamp, frame_id="map"), info=info, data=array("b", bytes(cells)))


def _boxes(rooms: Rooms) -> Iterator[tuple[float, float, float, float]]:
    for room in rooms.rooms.values():
        if room.corners:
            yield (*room.corners[0], *room.corners[2])
