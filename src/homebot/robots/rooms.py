"""The rooms of the house, found by the positions of robots. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Final, final

from homebot.places.room_shapes import RoomAt, RoomShape, RoomShapes
from homebot.robots.evidence import ROOM_ERROR, MapPose

__all__ = ["RobotRooms"]

_LEAVING: Final = 0.2
"""Metres beyond its polygon up to which a robot stays in its room: in a doorway it would leave and enter otherwise."""


@final
class RobotRooms:
    """The polygons of rooms.

    Args:
        shapes: Those that the house states, which win over those of maps.
    """

    def __init__(self, shapes: Iterable[RoomShape] = ()) -> None:
        self._by_map = {"": tuple(shapes)}
        self._set()

    def replace(self, name: str, shapes: Iterable[RoomShape]) -> None:
        """Take *shapes* in place of those of the map *name*; the map without a name is the house's."""
        self._by_map[name] = tuple(shapes)
        self._set()

    def _set(self) -> None:
        stated = {one.room for one in self._by_map[""]}
        others = (one for name, shapes in self._by_map.items() if name for one in shapes if one.room not in stated)
        self._shapes = RoomShapes((*self._by_map[""], *others))
        floors = {one.floor for one in self._shapes.shapes}
        self._only_floor = floors.pop() if len(floors) == 1 else ""

    def floor_of(self, stated: str) -> str:
        """Return the floor *stated*, or the only one."""
        return stated or self._only_floor

    def room_at(self, at: MapPose, floor: str, before: str) -> RoomAt | None:
        """Return the room at a position on *floor*: that of *before*, until the robot is 0.2 m out of it."""
        found = self._shapes.room_at(at.x, at.y, floor)
        if before and (found is None or found.room != before):
            for shape in self._shapes.shapes:
                if shape.room == before and shape.floor == floor:
                    is_inside = shape.polygon.contains(at.x, at.y)
                    distance = 0.0 if is_inside else shape.polygon.border_distance(at.x, at.y)
                    if distance <= _LEAVING:
                        return RoomAt(before, is_nearest=not is_inside, distance=distance)
        return found

    def error_in(self, room: str) -> float:
        """Return by how many metres a position may be wrong of which only the room is known."""
        boxes = [one.polygon.box for one in self._shapes.shapes if one.room == room]
        return max((math.hypot(one.right - one.left, one.top - one.bottom) / 2 for one in boxes), default=ROOM_ERROR)
