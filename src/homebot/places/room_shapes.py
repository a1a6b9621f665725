"""The room at a point of a floor plan. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from math import floor
from typing import NamedTuple, final

from homebot.places.polygon import Polygon

__all__ = ["NEARBY", "RoomAt", "RoomShape", "RoomShapes"]

NEARBY = 0.5
"""Metres from a room within which a point that is in no room belongs to it: walls and doorways."""

_LARGEST_CELLS = 20_000


class RoomShape(NamedTuple):
    """A room's polygon on its floor; a room may have several.

    Attributes:
        room: The room.
        floor: Its floor.
        polygon: Its area.
    """

    room: str
    floor: str
    polygon: Polygon


class RoomAt(NamedTuple):
    """The room of a point.

    Attributes:
        room: The room.
        is_nearest: Whether the point is in no room, and this is the nearest.
        distance: Metres from the point to the room; 0 inside.
    """

    room: str
    is_nearest: bool = False
    distance: float = 0.0


@final
class RoomShapes:
    """The polygons of all rooms, found by position: each is listed in every square metre that it touches.

    Args:
        shapes: The polygons.
    """

    def __init__(self, shapes: Iterable[RoomShape]) -> None:
        self.shapes = tuple(sorted(shapes, key=lambda one: (one.polygon.area, one.room)))
        self._cells: dict[tuple[str, int, int], list[RoomShape]] = {}
        self._large: list[RoomShape] = []
        for shape in self.shapes:
            box = shape.polygon.box
            columns = range(floor(box.left - NEARBY), floor(box.right + NEARBY) + 1)
            rows = range(floor(box.bottom - NEARBY), floor(box.top + NEARBY) + 1)
            if len(columns) * len(rows) > _LARGEST_CELLS:
                self._large.append(shape)
                continue
            for column in columns:
                for row in rows:
                    self._cells.setdefault((shape.floor, column, row), []).append(shape)

    def room_at(self, x: float, y: float, level: str = "") -> RoomAt | None:
        """Return the smallest room on the floor *level* that holds a point, else the nearest within 0.5 m."""
        near = self.near(x, y, level)
        inside = [one for one in near if one.polygon.contains(x, y)]
        if inside:
            return RoomAt(min(inside, key=lambda one: (one.polygon.area, one.room)).room)
        distances = [(one.polygon.border_distance(x, y), one.room) for one in near]
        distance, room = min(distances, default=(NEARBY + 1, ""))
        return RoomAt(room, is_nearest=True, distance=distance) if distance <= NEARBY else None

    def near(self, x: float, y: float, level: str = "") -> list[RoomShape]:
        """Return the polygons on the floor *level* that may hold a point, or be within 0.5 m of it."""
        return [*self._cells.get((level, floor(x), floor(y)), ()), *(one for one in self._large if one.floor == level)]
