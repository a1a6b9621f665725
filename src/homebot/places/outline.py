"""Outlines of rooms on pixel maps, and their simplification. Pure."""

import math
from bisect import bisect_right
from collections.abc import Iterator, Mapping, Sequence
from typing import Final, TypeAlias

from homebot.errors import UsageError
from homebot.places.polygon import Point, Polygon, foot, signed_area

_TOLERANCES: Final = (0.15, 0.3, 0.5)
MAX_CORNERS: Final = 30
"""The number of corners above which distances through a room take over a millisecond."""


_Corner: TypeAlias = tuple[int, int]


def traced(rows: Mapping[int, Sequence[int]]) -> list[_Corner]:
    """Return the corners of the largest ring around pixels; pixels that only touch at a corner are joined by a third.

    Between the corners in a row, or in a column, every other segment is an edge.

    Args:
        rows: For each row, the columns at which pixels alternately begin and end, in order.
    """
    across: dict[_Corner, _Corner] = {}
    columns: dict[int, list[int]] = {}
    above: set[int] = set()
    for row in range(min(rows, default=0), max(rows, default=-1) + 2):
        here = set(rows.get(row, ()))
        ends = sorted(above), sorted(here)
        for x in sorted(above & here):
            is_above, is_here = (bisect_right(end, x) % 2 for end in ends)  # an even number of ends is moved below x
            if x in here and is_above != is_here:
                here ^= {x - 1, x} if is_here else {x, x + 1}
        corners = sorted(above ^ here)
        for left, right in zip(corners[::2], corners[1::2], strict=True):
            across[left, row], across[right, row] = (right, row), (left, row)
            columns.setdefault(left, []).append(row)
            columns.setdefault(right, []).append(row)
        above = here
    down = {}
    for x, ys in columns.items():
        for upper, lower in zip(ys[::2], ys[1::2], strict=True):
            down[x, upper], down[x, lower] = (x, lower), (x, upper)
    return max(_rings(across, down), key=lambda ring: abs(signed_area(ring)), default=[])


def _rings(across: dict[_Corner, _Corner], down: Mapping[_Corner, _Corner]) -> Iterator[list[_Corner]]:
    """Yield the rings of edges, which alternate between *across* and *down*, each from one end to the other."""
    for start in tuple(across):
        ring, at = [], start
        while at in across:
            other = across.pop(at)
            del across[other]
            ring += [at, other]
            at = down[other]
        if ring:
            yield ring


def simplified(ring: Sequence[Point]) -> tuple[Point, ...]:
    """Return *ring* with at most 30 of its corners; empty if these do not form a polygon."""
    if not ring:
        return ()
    start = ring.index(min(ring))  # a corner that is kept
    ring = [*ring[start:], *ring[:start]]
    far = max(range(len(ring)), key=lambda index: math.dist(ring[0], ring[index]))
    for tolerance in _TOLERANCES:
        kept = (*_thin([*ring[: far + 1]], tolerance)[:-1], *_thin([*ring[far:], ring[0]], tolerance)[:-1])
        if len(kept) <= MAX_CORNERS or tolerance == _TOLERANCES[-1]:
            try:
                return Polygon(kept).rings[0]
            except UsageError:  # edges cross: try the next tolerance
                continue
    return ()


def _thin(line: Sequence[Point], tolerance: float) -> list[Point]:
    """Return the points of *line* that are needed to stay within *tolerance* of it (Douglas-Peucker)."""
    kept = {0, len(line) - 1}
    spans = [(0, len(line) - 1)]
    while spans:
        first, last = spans.pop()
        edge = line[first], line[last]
        distances = [(math.dist(line[index], foot(*line[index], edge)), index) for index in range(first + 1, last)]
        farthest, index = max(distances, default=(0.0, 0))
        if farthest > tolerance:
            kept.add(index)
            spans += [(first, index), (index, last)]
    return [line[index] for index in sorted(kept)]
