"""Simplification of the outlines of rooms, which follow pixels. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from homebot.errors import UsageError
from homebot.places.polygon import Point, Polygon

__all__ = ["simplified"]

_TOLERANCES: Final = (0.15, 0.3, 0.5)
_MOST_CORNERS: Final = 30
"""Corners above which distances through a room take over a millisecond."""


def simplified(ring: Sequence[Point]) -> tuple[Point, ...]:
    """Return *ring* with at most 30 corners, which are some of its own; empty if that makes no polygon."""
    if not ring:
        return ()
    far = max(range(len(ring)), key=lambda index: math.dist(ring[0], ring[index]))
    for tolerance in _TOLERANCES:
        kept = (*_thinned([*ring[: far + 1]], tolerance)[:-1], *_thinned([*ring[far:], ring[0]], tolerance)[:-1])
        if len(kept) <= _MOST_CORNERS or tolerance == _TOLERANCES[-1]:
            try:
                return Polygon(kept).rings[0]
            except UsageError:  # edges cross: try the next tolerance
                continue
    return ()


def _thinned(line: Sequence[Point], tolerance: float) -> list[Point]:
    """Return the points of *line* that are needed to stay within *tolerance* of it (Douglas and Peucker)."""
    kept = {0, len(line) - 1}
    spans = [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        distances = [(_distance(line[one], line[first], line[last]), one) for one in range(first + 1, last)]
        farthest, index = max(distances, default=(0.0, 0))
        if farthest > tolerance:
            kept.add(index)
            spans += [(first, index), (index, last)]
    return [line[one] for one in sorted(kept)]


def _distance(point: Point, begin: Point, end: Point) -> float:
    dx, dy = end[0] - begin[0], end[1] - begin[1]
    length = dx * dx + dy * dy
    share = ((point[0] - begin[0]) * dx + (point[1] - begin[1]) * dy) / length if length else 0.0
    share = min(1.0, max(0.0, share))
    return math.dist(point, (begin[0] + share * dx, begin[1] + share * dy))
