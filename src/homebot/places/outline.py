"""Simplification of the outlines of rooms, which follow pixels. Pure."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

from homebot.errors import UsageError
from homebot.places.polygon import Point, Polygon, foot

__all__ = ["MOST_CORNERS", "simplified"]

_TOLERANCES: Final = (0.15, 0.3, 0.5)
MOST_CORNERS: Final = 30
"""Corners above which distances through a room take over a millisecond."""


def simplified(ring: Sequence[Point]) -> tuple[Point, ...]:
    """Return *ring* with at most 30 corners, which are some of its own; empty if that makes no polygon."""
    if not ring:
        return ()
    start = ring.index(min(ring))  # a corner, which stays
    ring = [*ring[start:], *ring[:start]]
    far = max(range(len(ring)), key=lambda index: math.dist(ring[0], ring[index]))
    for tolerance in _TOLERANCES:
        kept = (*_thinned([*ring[: far + 1]], tolerance)[:-1], *_thinned([*ring[far:], ring[0]], tolerance)[:-1])
        if len(kept) <= MOST_CORNERS or tolerance == _TOLERANCES[-1]:
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
        edge = line[first], line[last]
        distances = [(math.dist(line[one], foot(*line[one], edge)), one) for one in range(first + 1, last)]
        farthest, index = max(distances, default=(0.0, 0))
        if farthest > tolerance:
            kept.add(index)
            spans += [(first, index), (index, last)]
    return [line[one] for one in sorted(kept)]
