"""The map of a robot vacuum: its rooms as segments, and where the robot is. Pure.

Lengths are metres from the bottom left, y up.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import cycle
from typing import ClassVar, Final, NamedTuple, Protocol, final

from homebot.places.outline import traced
from homebot.places.rigid import MapPose
from homebot.plugins import load_plugin, plugin_names

_GROUP: Final = "homebot.vacuum_maps"

_NEARBY: Final = 0.5

_DOORWAY: Final = 0.25
"""Metres over which two segments touch, at least, where a door joins them."""

_NONE: Final = -1


class MapReader(Protocol):
    """Reads the maps of one kind of vacuum; the plug-in group is ``homebot.vacuum_maps``.

    Attributes:
        origin: The origin that its announcements state.
        state_topic: The topic of ``lost`` and ``ready`` below that of the vacuum.
        status_topic: The topic of its activity, such as ``cleaning`` or ``docked``.
        map_topic: The topic of its map.
    """

    origin: ClassVar[str]
    state_topic: ClassVar[str]
    status_topic: ClassVar[str]
    map_topic: ClassVar[str]

    def read(self, payload: bytes) -> VacuumMap:
        """Return the map in *payload*.

        Raises:
            WireError: It is no such map, or one that is too large.
        """
        ...


def map_readers() -> tuple[MapReader, ...]:
    """Return the installed readers."""
    return tuple(load_plugin(_GROUP, name)() for name in plugin_names(_GROUP))


class VacuumSegment(NamedTuple):
    """A room as the vacuum sees it.

    Attributes:
        id: Its number, as text; it changes where the map is segmented anew.
        rows: Its pixels: in each row the columns at which it begins and ends, by turns.
    """

    id: str
    name: str
    rows: Mapping[int, tuple[int, ...]]


@final
class VacuumMap(NamedTuple):
    """A map.

    Attributes:
        vendor_id: The vacuum's own number of the map; empty without one.
        pixel: Metres of a pixel.
        robot: Where the robot is; None where that is not stated.
    """

    vendor_id: str
    pixel: float
    height: float
    segments: tuple[VacuumSegment, ...]
    robot: MapPose | None

    def segment_at(self, x: float, y: float) -> tuple[VacuumSegment, float] | None:
        """Return the segment on which a position is, else the nearest within 0.5 m, with its metres from there."""
        across, down = round(x / self.pixel, 6), round((self.height - y) / self.pixel, 6)
        for segment in self.segments:
            if bisect_right(segment.rows.get(math.floor(down), ()), across) % 2:
                return segment, 0.0
        reach = _NEARBY / self.pixel
        near = [
            (math.hypot(max(begin - across, 0.0, across - end), max(row - down, 0.0, down - row - 1)), number)
            for number, segment in enumerate(self.segments)
            for row in range(math.floor(down - reach), math.ceil(down + reach) + 1)
            for begin, end in zip(segment.rows.get(row, ())[::2], segment.rows.get(row, ())[1::2], strict=True)
        ]
        distance, number = min(near, default=(math.inf, 0))
        return (self.segments[number], distance * self.pixel) if distance <= reach else None

    def joined(self) -> Iterator[tuple[str, str]]:
        """Yield the ids of each two segments that touch as in a doorway, over 0.25 m or more."""
        rows: dict[int, list[tuple[int, int]]] = {}
        for number, segment in enumerate(self.segments):
            for row, ends in segment.rows.items():
                rows.setdefault(row, []).extend(zip(ends, cycle((number, _NONE)), strict=False))
        pixels: Counter[frozenset[int]] = Counter()
        for row, marks in rows.items():
            for pair, length in _touching(marks, rows.get(row + 1, ())):
                pixels[pair] += length
        for pair, length in pixels.items():
            if len(pair) > 1 and length * self.pixel >= _DOORWAY:
                first, other = (self.segments[number].id for number in sorted(pair))
                yield first, other

    def outline(self, segment: VacuumSegment) -> tuple[tuple[float, float], ...]:
        """Return the corners of the largest ring around the pixels of *segment*, in metres."""
        return tuple((x * self.pixel, self.height - y * self.pixel) for x, y in traced(segment.rows))


def _touching(row: Iterable[tuple[int, int]], below: Iterable[tuple[int, int]]) -> Iterator[tuple[frozenset[int], int]]:
    """Yield each two segments that touch in a row, or in it and the one *below*, and how many pixels do.

    A row is given by the columns from which on its pixels are of a segment, by its number, or of none.
    """
    here, last, ended = [_NONE, _NONE], 0, (0, _NONE)
    for x, side, number in sorted([*((x, 0, number) for x, number in row), *((x, 1, number) for x, number in below)]):
        if _NONE not in here:
            yield frozenset(here), x - last
        if side == 0 and number == _NONE:
            ended = x, here[0]
        elif side == 0 and x == ended[0]:
            yield frozenset((number, ended[1])), 1
        last, here[side] = x, number
