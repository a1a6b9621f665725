"""The area that two polygons share. Pure."""

from __future__ import annotations

from itertools import pairwise

from homebot.places.polygon import Edge, Polygon

__all__ = ["overlap_area"]


def overlap_area(one: Polygon, other: Polygon) -> float:
    """Return the square metres that two polygons share.

    Between two heights at which no corner lies and no edges cross, the shared width grows evenly; so it is measured in
    the middle of each such strip.
    """
    bottom, top = max(one.box.bottom, other.box.bottom), min(one.box.top, other.box.top)
    if bottom >= top or one.box.left >= other.box.right or other.box.left >= one.box.right:
        return 0.0
    first, second = [*one.edges()], [*other.edges()]
    heights = {y for (_, y), _ in (*first, *second)} | {y for a in first for b in second for y in _crossing(a, b)}
    levels = sorted({bottom, top, *(y for y in heights if bottom < y < top)})
    return sum((high - low) * _shared_width(first, second, (low + high) / 2) for low, high in pairwise(levels))


def _shared_width(first: list[Edge], second: list[Edge], y: float) -> float:
    ends = sorted([(x, 0) for x in _cut(first, y)] + [(x, 1) for x in _cut(second, y)])
    inside = [False, False]
    width = 0.0
    for (x, which), (further, _) in pairwise(ends):
        inside[which] = not inside[which]
        width += further - x if all(inside) else 0.0
    return width


def _cut(edges: list[Edge], y: float) -> list[float]:
    return [(x2 - x1) * (y - y1) / (y2 - y1) + x1 for (x1, y1), (x2, y2) in edges if (y1 > y) != (y2 > y)]


def _crossing(a: Edge, b: Edge) -> tuple[float, ...]:
    """Return the height at which two edges cross; empty for none."""
    (ax, ay), (bx, by) = a
    (cx, cy), (dx, dy) = b
    across = (bx - ax) * (dy - cy) - (by - ay) * (dx - cx)
    if not across:
        return ()
    share = ((cx - ax) * (dy - cy) - (cy - ay) * (dx - cx)) / across
    along = ((cx - ax) * (by - ay) - (cy - ay) * (bx - ax)) / across
    return (ay + share * (by - ay),) if 0 <= share <= 1 and 0 <= along <= 1 else ()
