"""Polygons of rooms in the plane, in metres. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple, TypeAlias, final

from homebot.errors import UsageError
from homebot.places.plan import Point as Point

Edge: TypeAlias = tuple[Point, Point]

MIN_AREA = 0.01
LARGEST = 10_000.0
MAX_CORNERS = 1000

_NEARLY = 1e-6
_STEPS = 20
"""Sample points along each side of the rectangle in which two polygons may overlap."""


class Box(NamedTuple):
    """The bounding box of a polygon."""

    left: float
    bottom: float
    right: float
    top: float


@final
class Polygon:
    """An area with straight edges, perhaps with holes.

    A point on an edge shared by two polygons is in exactly one of them (half-open crossing rule).

    Args:
        outer: The corners, clockwise or counter-clockwise; repeated corners count once.

    Attributes:
        rings: The outer ring counter-clockwise, then the holes clockwise.
        area: Square metres.

    Raises:
        UsageError: A ring has fewer than 3 corners or crosses itself, a number is not finite or beyond 10 km, the area
        is below 0.01 m², or there are more than 1,000 corners.
    """

    __slots__ = ("area", "box", "rings")

    def __init__(self, outer: Sequence[Point], holes: Iterable[Sequence[Point]] = ()) -> None:
        rings = [_ring(outer, is_hole=False), *(_ring(hole, is_hole=True) for hole in holes)]
        if sum(map(len, rings)) > MAX_CORNERS:
            raise UsageError(f"has {sum(map(len, rings)):,} corners; {MAX_CORNERS:,} is the limit")
        self.rings = tuple(rings)
        # edges that cross are refused, in a sweep along the x axis
        edges = sorted(self.edges(), key=lambda edge: min(edge[0][0], edge[1][0]))
        active: list[Edge] = []
        for edge in edges:
            left = min(edge[0][0], edge[1][0])
            active = [edge for edge in active if max(edge[0][0], edge[1][0]) >= left]
            for other in active:
                if _cross(edge, other):
                    raise UsageError(f"has edges that cross, near {edge[0][0]:g}, {edge[0][1]:g}")
            active.append(edge)
        self.area = sum(map(signed_area, rings))
        if self.area < MIN_AREA:
            raise UsageError(f"has an area of {self.area:g} m²; {MIN_AREA:g} m² is the least")
        xs, ys = [x for x, _ in rings[0]], [y for _, y in rings[0]]
        self.box = Box(min(xs), min(ys), max(xs), max(ys))

    def contains(self, x: float, y: float) -> bool:
        """Return whether the point is inside."""
        is_inside = False
        for ring in self.rings:
            x1, y1 = ring[-1]
            for x2, y2 in ring:
                if (y1 > y) != (y2 > y) and x < (x2 - x1) * (y - y1) / (y2 - y1) + x1:
                    is_inside = not is_inside
                x1, y1 = x2, y2
        return is_inside

    def border_distance(self, x: float, y: float) -> float:
        """Return the distance from the point to the nearest edge, in metres."""
        return math.sqrt(min(_squared_distance(x, y, edge) for edge in self.edges()))

    def holds(self, x: float, y: float) -> bool:
        """Return whether the point is inside or on the border."""
        return self.contains(x, y) or self.border_distance(x, y) < _NEARLY

    def overlap(self, other: Polygon) -> float:
        """Return the approximate shared area of two polygons in m²; 0 if all corners of one are in the other."""
        left, bottom = max(self.box.left, other.box.left), max(self.box.bottom, other.box.bottom)
        right, top = min(self.box.right, other.box.right), min(self.box.top, other.box.top)
        if left >= right or bottom >= top:
            return 0.0
        if any(
            all(outer.holds(*corner) for corner in inner.rings[0]) for outer, inner in ((self, other), (other, self))
        ):
            return 0.0
        width, height = (right - left) / _STEPS, (top - bottom) / _STEPS
        points = ((left + (i + 0.5) * width, bottom + (j + 0.5) * height) for i in range(_STEPS) for j in range(_STEPS))
        return sum(self.contains(*point) and other.contains(*point) for point in points) * width * height

    def nearest_edge(self, x: float, y: float) -> Edge:
        """Return the edge nearest to a point."""
        return min(self.edges(), key=lambda edge: _squared_distance(x, y, edge))

    def nearest_inside(self, x: float, y: float, margin: float = 0.001) -> Point:
        """Return the point itself if it is at least *margin* metres inside, otherwise the nearest such point."""
        if self.contains(x, y) and self.border_distance(x, y) >= margin:
            return x, y
        edge = self.nearest_edge(x, y)
        px, py = foot(x, y, edge)
        (x1, y1), (x2, y2) = edge
        length = math.hypot(x2 - x1, y2 - y1)
        return px - (y2 - y1) / length * margin, py + (x2 - x1) / length * margin  # the inside is to the left

    def centroid(self) -> Point:
        """Return the centre of the area."""
        x = y = 0.0
        for (x1, y1), (x2, y2) in self.edges():
            cross = x1 * y2 - x2 * y1
            x += (x1 + x2) * cross
            y += (y1 + y2) * cross
        return x / (6 * self.area), y / (6 * self.area)

    def edges(self) -> Iterator[Edge]:
        """Yield the edges of all rings; the inside is to their left."""
        for ring in self.rings:
            yield from zip(ring, (*ring[1:], ring[0]), strict=True)


def _ring(corners: Sequence[Point], *, is_hole: bool) -> tuple[Point, ...]:
    for x, y in corners:
        if not (abs(x) <= LARGEST and abs(y) <= LARGEST):  # false for NaN too
            raise UsageError(f"has the corner {x:g}, {y:g}; {LARGEST:,.0f} m is the limit")
    ring = [corner for index, corner in enumerate(corners) if corner != corners[index - 1]]
    if len(ring) < 3:
        raise UsageError(f"has {len(ring)} different corners; 3 is the least")
    if (signed_area(ring) < 0) is not is_hole:
        ring.reverse()
    return tuple(ring)


def signed_area(ring: Sequence[Point]) -> float:
    """Return the area of *ring*, negative if its corners are clockwise."""
    return sum(x1 * y2 - x2 * y1 for (x1, y1), (x2, y2) in zip(ring, (*ring[1:], ring[0]), strict=True)) / 2


def foot(x: float, y: float, edge: Edge) -> Point:
    """Return the point on *edge* nearest to a point."""
    (x1, y1), (x2, y2) = edge
    dx, dy = x2 - x1, y2 - y1
    share = min(1.0, max(0.0, ((x - x1) * dx + (y - y1) * dy) / (dx * dx + dy * dy or 1.0)))
    return x1 + share * dx, y1 + share * dy


def _squared_distance(x: float, y: float, edge: Edge) -> float:
    px, py = foot(x, y, edge)
    return (px - x) ** 2 + (py - y) ** 2


def _cross(a: Edge, b: Edge) -> bool:
    """Return whether two edges cross at a point that is not an end of either."""
    return _side(a, b[0]) * _side(a, b[1]) < 0 and _side(b, a[0]) * _side(b, a[1]) < 0


def _side(edge: Edge, point: Point) -> float:
    (x1, y1), (x2, y2) = edge
    return (x2 - x1) * (point[1] - y1) - (y2 - y1) * (point[0] - x1)
