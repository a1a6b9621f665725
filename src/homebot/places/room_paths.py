"""Shortest ways inside a room: straight lines around its corners. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from heapq import heappop, heappush
from itertools import pairwise
from typing import final

from homebot.places.outline import MOST_CORNERS, simplified
from homebot.places.polygon import Point, Polygon

__all__ = ["RoomPaths"]


@final
class RoomPaths:
    """Ways inside one room. Of an area with more than 30 corners the outer ring is simplified to within 0.5 m.

    Args:
        areas: Its areas; a way leads from one to another where they touch or overlap.
    """

    def __init__(self, *areas: Polygon) -> None:
        self.areas = tuple(map(_simplified, areas))
        self._edges = tuple(edge for one in self.areas for edge in one.edges())
        self._corners = tuple(_inward_corners(self.areas[0]) if len(areas) == 1 else self._joint_corners())
        self._between = [self._from_corner(index) for index in range(len(self._corners))]

    def distance(self, start: Point, end: Point) -> float:
        """Return metres between two points; along a straight line if no way is found, as for points outside."""
        if not self._corners or self._sees(start, end):
            return math.dist(start, end)
        first = self._visible(start)
        last = self._visible(end)
        ways = (to_first + self._between[one][other] + to_last for one, to_first in first for other, to_last in last)
        found = min(ways, default=math.inf)
        return math.dist(start, end) if math.isinf(found) else found

    def _visible(self, point: Point) -> list[tuple[int, float]]:
        return [
            (index, math.dist(point, corner)) for index, corner in enumerate(self._corners) if self._sees(point, corner)
        ]

    def _from_corner(self, start: int) -> list[float]:
        """Return metres from a corner to each; infinite where no way leads."""
        found = [math.inf] * len(self._corners)
        heap = [(0.0, start)]
        while heap:
            distance, index = heappop(heap)
            if distance >= found[index]:
                continue
            found[index] = distance
            for other, further in self._visible(self._corners[index]):
                if distance + further < found[other]:
                    heappush(heap, (distance + further, other))
        return found

    def _sees(self, start: Point, end: Point) -> bool:
        """Return whether the straight line between two points stays inside."""
        (x1, y1), (x2, y2) = start, end
        shares = sorted([0.0, *self._meetings(start, end), 1.0])
        middles = ((first + last) / 2 for first, last in pairwise(shares) if last - first > 1e-9)
        return all(self._is_inside(x1 + share * (x2 - x1), y1 + share * (y2 - y1)) for share in middles)

    def _meetings(self, start: Point, end: Point) -> Iterator[float]:
        """Yield the shares of a line at which it meets an edge."""
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

    def _is_inside(self, x: float, y: float) -> bool:
        return any(one.holds(x, y) for one in self.areas)

    def _joint_corners(self) -> dict[Point, None]:
        """Return the corners of several areas, and the points where their edges cross."""
        found: dict[Point, None] = {}
        for (x1, y1), (x2, y2) in self._edges:
            for share in (0.0, *self._meetings((x1, y1), (x2, y2))):
                found[x1 + share * (x2 - x1), y1 + share * (y2 - y1)] = None
        return found


def _inward_corners(polygon: Polygon) -> Iterator[Point]:
    for ring in polygon.rings:
        for index, (x, y) in enumerate(ring):
            (px, py), (nx, ny) = ring[index - 1], ring[(index + 1) % len(ring)]
            if (x - px) * (ny - y) - (y - py) * (nx - x) < 0:  # a turn to the right, and the inside is to the left
                yield x, y


def _simplified(polygon: Polygon) -> Polygon:
    ring: Sequence[Point] = () if sum(map(len, polygon.rings)) <= MOST_CORNERS else simplified(polygon.rings[0])
    return Polygon(ring) if ring else polygon
