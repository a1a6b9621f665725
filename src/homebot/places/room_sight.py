"""Visibility inside a room, and the corners at which ways turn. Pure."""

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import final

from homebot.places.outline import MAX_CORNERS, simplified
from homebot.places.polygon import Point, Polygon


@final
class RoomSight:
    """Visibility inside one room; an area with more than 30 corners is simplified to within 0.5 m.

    Args:
        areas: Its areas. Ways connect areas that touch or overlap; between areas that do not, every line counts as a
        way.

    Attributes:
        areas: The simplified areas.
        corners: The points at which ways turn; empty if every line is a way.
    """

    def __init__(self, *areas: Polygon) -> None:
        self.areas = tuple(map(_simplify, areas))
        self._edges = tuple(edge for area in self.areas for edge in area.edges())
        self.corners = tuple(_inward_corners(self.areas[0]) if len(areas) == 1 else self._joint_corners())

    def sees(self, start: Point, end: Point) -> bool:
        """Return whether the straight line between two points stays inside."""
        if not self.corners:
            return True
        (x1, y1), (x2, y2) = start, end
        shares = sorted([0.0, *self._meetings(start, end), 1.0])
        middles = ((first + last) / 2 for first, last in pairwise(shares) if last - first > 1e-9)
        return all(self._holds(x1 + share * (x2 - x1), y1 + share * (y2 - y1)) for share in middles)

    def inside(self, point: Point) -> Point:
        """Return *point* if it is inside, else the nearest point inside."""
        if self._holds(*point):
            return point
        return min((area.nearest_inside(*point) for area in self.areas), key=lambda one: math.dist(one, point))

    def _meetings(self, start: Point, end: Point) -> Iterator[float]:
        """Yield the fractions of a line at which it meets an edge."""
        (x1, y1), (x2, y2) = start, end
        dx, dy = x2 - x1, y2 - y1
        for (ax, ay), (bx, by) in self._edges:
            ex, ey = bx - ax, by - ay
            across = dx * ey - dy * ex
            if abs(across) < 1e-12:
                continue
            share = ((ax - x1) * ey - (ay - y1) * ex) / across
            if 0 < share < 1 and 0 <= ((ax - x1) * dy - (ay - y1) * dx) / across <= 1:
                yield share

    def _holds(self, x: float, y: float) -> bool:
        return any(area.holds(x, y) for area in self.areas)

    def _joint_corners(self) -> list[Point]:
        """Return the corners of several areas, and the points where their edges cross; none if they are disjoint."""
        areas_by_corner: dict[Point, list[Polygon]] = {}
        for start, end in self._edges:
            for share in (0.0, *self._meetings(start, end)):
                x, y = (a + share * (b - a) for a, b in zip(start, end, strict=True))
                areas_by_corner[x, y] = [area for area in self.areas if area.holds(x, y)]
        shared = [areas for areas in areas_by_corner.values() if len(areas) > 1]
        return [*areas_by_corner] if all(any(area in areas for areas in shared) for area in self.areas) else []


def _inward_corners(polygon: Polygon) -> Iterator[Point]:
    for ring in polygon.rings:
        for index, (x, y) in enumerate(ring):
            (px, py), (nx, ny) = ring[index - 1], ring[(index + 1) % len(ring)]
            if (x - px) * (ny - y) - (y - py) * (nx - x) < 0:  # a right turn, with the inside on the left
                yield x, y


def _simplify(polygon: Polygon) -> Polygon:
    ring: Sequence[Point] = () if sum(map(len, polygon.rings)) <= MAX_CORNERS else simplified(polygon.rings[0])
    return Polygon(ring) if ring else polygon
