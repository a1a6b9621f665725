"""Shortest ways inside a polygon: straight lines around its inward corners. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from heapq import heappop, heappush
from itertools import pairwise
from typing import final

from homebot.places.polygon import Point, Polygon

__all__ = ["RoomPaths"]

_NEARLY = 1e-6
_MOST_CORNERS = 30
"""Corners of a room that ways are computed with: the time of a pose grows with their square."""

_TOLERANCES = (0.15, 0.3, 0.5)


@final
class RoomPaths:
    """Ways inside one polygon.

    A convex polygon has straight ways only. Of one with more than 30 corners the outer ring is simplified to within
    0.5 m.

    Args:
        polygon: The polygon.
    """

    def __init__(self, polygon: Polygon) -> None:
        self.polygon = _simplified(polygon)
        self._edges = tuple(self.polygon.edges())
        self._corners = tuple(_inward_corners(self.polygon))
        self._between = [self._from_corner(index) for index in range(len(self._corners))]

    def distance(self, start: Point, end: Point) -> float:
        """Return metres between two points; along a straight line if no way is found, as for points outside."""
        if not self._corners or self._sees(start, end):
            return math.dist(start, end)
        first = self._visible(start)
        last = self._visible(end)
        ways = (to_first + self._between[one][other] + to_last for one, to_first in first for other, to_last in last)
        return min(ways, default=math.dist(start, end))

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
        shares = [0.0, 1.0]
        (x1, y1), (x2, y2) = start, end
        dx, dy = x2 - x1, y2 - y1
        for (ax, ay), (bx, by) in self._edges:
            ex, ey = bx - ax, by - ay
            across = dx * ey - dy * ex
            if abs(across) < 1e-12:
                continue
            share = ((ax - x1) * ey - (ay - y1) * ex) / across
            along = ((ax - x1) * dy - (ay - y1) * dx) / across
            if 0 < share < 1 and 0 <= along <= 1:
                if _NEARLY < along < 1 - _NEARLY and _NEARLY < share < 1 - _NEARLY:
                    return False
                shares.append(share)
        shares.sort()
        middles = ((first + last) / 2 for first, last in pairwise(shares) if last - first > 1e-9)
        return all(self._is_inside(x1 + share * dx, y1 + share * dy) for share in middles)

    def _is_inside(self, x: float, y: float) -> bool:
        return self.polygon.contains(x, y) or self.polygon.border_distance(x, y) < _NEARLY


def _inward_corners(polygon: Polygon) -> list[Point]:
    found: list[Point] = []
    for ring in polygon.rings:
        for index, (x, y) in enumerate(ring):
            (px, py), (nx, ny) = ring[index - 1], ring[(index + 1) % len(ring)]
            if (x - px) * (ny - y) - (y - py) * (nx - x) < 0:  # a turn to the right, and the inside is to the left
                found.append((x, y))
    return found


def _simplified(polygon: Polygon) -> Polygon:
    if sum(map(len, polygon.rings)) <= _MOST_CORNERS:
        return polygon
    ring: Sequence[Point] = polygon.rings[0]
    for tolerance in _TOLERANCES:
        half = len(ring) // 2
        simple = [*_line(ring[: half + 1], tolerance)[:-1], *_line([*ring[half:], ring[0]], tolerance)[:-1]]
        if len(simple) <= _MOST_CORNERS or tolerance == _TOLERANCES[-1]:
            return Polygon(simple) if len(simple) >= 3 else polygon
    return polygon


def _line(points: Sequence[Point], tolerance: float) -> list[Point]:
    """Return *points* without those that lie within *tolerance* of the line of the others (Douglas and Peucker)."""
    stack, kept = [(0, len(points) - 1)], {0, len(points) - 1}
    while stack:
        first, last = stack.pop()
        (x1, y1), (x2, y2) = points[first], points[last]
        length = math.hypot(x2 - x1, y2 - y1)
        farthest, most = 0, tolerance
        for index in range(first + 1, last):
            x, y = points[index]
            away = abs((x2 - x1) * (y1 - y) - (x1 - x) * (y2 - y1)) / length if length else math.dist((x, y), (x1, y1))
            if away > most:
                farthest, most = index, away
        if farthest:
            kept.add(farthest)
            stack += [(first, farthest), (farthest, last)]
    return [points[index] for index in sorted(kept)]
