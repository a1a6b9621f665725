"""Ways through the doors of a house, to the nearest targets first. Pure.

In a room without a polygon, and to a place in a room that is not known more exactly, half a hop of 2 m is counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple, TypeAlias, final

from homebot.places.polygon import Point
from homebot.places.room_sight import RoomSight

__all__ = ["HALF_HOP", "Doorway", "PathFinder", "Spot", "Way"]

HALF_HOP = 2.0
"""Metres between a door and a place in a room whose shape is not known."""


class Spot(NamedTuple):
    """A place of a robot or a target.

    Attributes:
        room: The room.
        point: Its position in metres; None if only the room is known.
    """

    room: str
    point: Point | None = None


class Doorway(NamedTuple):
    """A door, or a stair, between two rooms.

    Attributes:
        name: Its name.
        rooms: The two rooms.
        points: For each way through it a point inside each room, 1 mm behind the threshold; empty if not known. A wide
            opening has several ways.
    """

    name: str
    rooms: tuple[str, str]
    points: tuple[tuple[Point, Point], ...] = ()


class Way(NamedTuple):
    """The way to a target.

    Attributes:
        target: The target.
        path: Metres to go.
        extra: Metres that are counted for doors on the way which are not open.
        doors: The names of the doors on the way.
    """

    target: str
    path: float
    extra: float
    doors: tuple[str, ...]


Crossing: TypeAlias = Callable[[str], float]
"""The metres that going through a door costs: 0 if it is open, infinite if it is locked."""


@dataclass(slots=True, eq=False, repr=False)
class _Node:
    """A corner of a room, or one way through a door as seen from one of its rooms.

    Attributes:
        spot: Its place.
        door: The door; empty for a corner.
        other: The same way, as seen from the other room.
        ways: The nodes of the room that it sees, each with its distance; None until it is asked for.
    """

    spot: Spot
    door: str = ""
    other: _Node | None = None
    ways: list[tuple[float, _Node]] | None = None


@final
class PathFinder:
    """Finds targets by the length of the way to them.

    Args:
        rooms: The inside of each room that has a polygon.
        doorways: The doors.
    """

    def __init__(self, rooms: Mapping[str, RoomSight], doorways: Iterable[Doorway]) -> None:
        self._rooms = rooms
        self._nodes = {name: [_Node(Spot(name, corner)) for corner in room.corners] for name, room in rooms.items()}
        self._targets: dict[str, Spot] = {}
        self._in_room: dict[str, set[str]] = {}
        self._reachable: tuple[AbstractSet[str], frozenset[str]] = frozenset(), frozenset()
        for doorway in doorways:
            for here, there in doorway.points or ((None, None),):
                node = _Node(self._inside(Spot(doorway.rooms[0], here)), doorway.name)
                node.other = _Node(self._inside(Spot(doorway.rooms[1], there)), doorway.name, node)
                for one in (node, node.other):
                    self._nodes.setdefault(one.spot.room, []).append(one)

    def put(self, target: str, place: Spot) -> None:
        """Spot a target, or move it."""
        self.discard(target)
        self._targets[target] = self._inside(place)
        self._in_room.setdefault(place.room, set()).add(target)

    def discard(self, target: str) -> None:
        """Remove a target."""
        place = self._targets.pop(target, None)
        if place is not None:
            self._in_room[place.room].discard(target)

    def place_of(self, target: str) -> Spot | None:
        """Return the place of a target."""
        return self._targets.get(target)

    def unreachable(self, room: str, locked: frozenset[str] = frozenset()) -> set[str]:
        """Return the targets to which no way leads from *room*, but for the *locked* doors."""
        known, though_locked = self._reachable
        if room not in known or locked != though_locked:
            found, waiting = {room}, [room]
            while waiting:
                for node in self._nodes.get(waiting.pop(), ()):
                    other = node.other
                    if other is not None and other.spot.room not in found and node.door not in locked:
                        found.add(other.spot.room)
                        waiting.append(other.spot.room)
            known = found
            self._reachable = found, locked
        return set[str]().union(*(self._in_room[one] for one in self._in_room.keys() - known))

    def nearest(
        self, start: Spot, crossing: Crossing, wanted: AbstractSet[str] | None = None, most: float = math.inf
    ) -> Iterator[Way]:
        """Yield each target that can be reached, by the metres of its way and of the doors on it, nearest first.

        Args:
            start: Where the ways begin.
            crossing: What going through each door costs.
            wanted: The only targets to look for; None for all.
            most: The most metres.
        """
        order = count()
        heap: list[tuple[float, str, int, float, float, tuple[str, ...], _Node | None, Spot]] = []
        done: set[str | _Node] = set()

        def push_all(
            spot: Spot, path: float, extra: float, doors: tuple[str, ...], ways: Iterable[tuple[float, _Node]]
        ) -> None:
            for metres, target, node in self._ahead(spot, ways, wanted):
                way = path + metres
                if way + extra <= most and (node or target) not in done:
                    heappush(heap, (way + extra, target, next(order), way, extra, doors, node, spot))

        begin = self._inside(start)
        nodes = self._nodes.get(start.room, ())
        push_all(begin, 0.0, 0.0, (), [(_metres(begin, node.spot, HALF_HOP), node) for node in nodes])
        while heap:
            _, target, _, path, extra, doors, node, origin = heappop(heap)
            if (node or target) in done or not self._sees(origin, node.spot if node else self._targets[target]):
                continue
            done.add(node or target)
            if node is None:
                yield Way(target, path, extra, doors)
            elif node.other is None:
                push_all(node.spot, path, extra, doors, self._ways(node))
            elif not math.isinf(toll := crossing(node.door)):
                done.add(node.other)  # a way back through the door would be longer
                push_all(node.other.spot, path, extra + toll, (*doors, node.door), self._ways(node.other))

    def _ahead(
        self, spot: Spot, ways: Iterable[tuple[float, _Node]], wanted: AbstractSet[str] | None
    ) -> Iterator[tuple[float, str, _Node | None]]:
        """Yield what the room of *spot* has, with metres through the air; only the nearest is looked at closely."""
        yield from ((metres, "", node) for metres, node in ways)
        here = self._in_room.get(spot.room, set())
        for target in here if wanted is None else here & wanted:
            yield _metres(spot, self._targets[target], HALF_HOP), target, None

    def _ways(self, node: _Node) -> list[tuple[float, _Node]]:
        if node.ways is None:
            others = (one for one in self._nodes[node.spot.room] if one is not node)
            node.ways = [
                (_metres(node.spot, one.spot, 2 * HALF_HOP), one) for one in others if self._sees(node.spot, one.spot)
            ]
        return node.ways

    def _inside(self, place: Spot) -> Spot:
        """Return *place*, or the nearest one that is in its room."""
        room = self._rooms.get(place.room)
        return place if room is None or place.point is None else Spot(place.room, room.inside(place.point))

    def _sees(self, start: Spot, end: Spot) -> bool:
        room = self._rooms.get(start.room)
        return room is None or start.point is None or end.point is None or room.sees(start.point, end.point)


def _metres(start: Spot, end: Spot, otherwise: float) -> float:
    """Return metres through the air between two places, *otherwise* if one of them is not known."""
    return otherwise if start.point is None or end.point is None else math.dist(start.point, end.point)
