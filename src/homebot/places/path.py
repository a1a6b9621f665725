"""Ways through the doors of a house, to the nearest targets first. Pure.

In a room without a polygon, and to a place in a room that is not known more exactly, half a hop of 2 m is counted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple, TypeAlias, final

from homebot.places.polygon import Point
from homebot.places.room_paths import RoomPaths

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
class _Gate:
    """One way through a door, as seen from one of its rooms.

    Attributes:
        other: The same way, as seen from the other room.
        ways: The gates of the room, each with its distance.
        targets: The distances of targets in the room that were asked for.
    """

    door: str
    spot: Spot
    other: _Gate | None = None
    ways: list[tuple[float, _Gate]] = field(default_factory=list)
    targets: dict[str, float] = field(default_factory=dict)


class _Step(NamedTuple):
    """The way to a target, or to a gate of the room that it ends in."""

    to: str | _Gate
    path: float
    extra: float = 0.0
    doors: tuple[str, ...] = ()


@final
class PathFinder:
    """Finds targets by the length of the way to them.

    Args:
        shapes: The paths inside each room that has a polygon.
        doorways: The doors.
    """

    def __init__(self, shapes: Mapping[str, RoomPaths], doorways: Iterable[Doorway]) -> None:
        self._shapes = shapes
        self._gates: dict[str, list[_Gate]] = {}
        self._targets: dict[str, Spot] = {}
        self._in_room: dict[str, set[str]] = {}
        self._reachable: tuple[AbstractSet[str], frozenset[str]] = frozenset(), frozenset()
        for doorway in doorways:
            for here, there in doorway.points or ((None, None),):
                gate = _Gate(doorway.name, Spot(doorway.rooms[0], here))
                gate.other = _Gate(doorway.name, Spot(doorway.rooms[1], there), gate)
                for one in (gate, gate.other):
                    self._gates.setdefault(one.spot.room, []).append(one)
        for gates in self._gates.values():
            for gate in gates:
                others = (one for one in gates if one is not gate)
                gate.ways = [(self._inside(gate.spot, one.spot, 2 * HALF_HOP), one) for one in others]

    def put(self, target: str, place: Spot) -> None:
        """Spot a target, or move it."""
        if self._targets.get(target) == place:
            return
        self.discard(target)
        self._targets[target] = place
        self._in_room.setdefault(place.room, set()).add(target)

    def discard(self, target: str) -> None:
        """Remove a target."""
        place = self._targets.pop(target, None)
        if place is not None:
            self._in_room[place.room].discard(target)
            for gate in self._gates.get(place.room, ()):
                gate.targets.pop(target, None)

    def place_of(self, target: str) -> Spot | None:
        """Return the place of a target."""
        return self._targets.get(target)

    def reachable_rooms(self, room: str, locked: frozenset[str] = frozenset()) -> AbstractSet[str]:
        """Return the rooms to which a way leads from *room*, that itself included, but for the *locked* doors."""
        known, though_locked = self._reachable
        if room in known and locked == though_locked:
            return known
        found, waiting = {room}, [room]
        while waiting:
            for gate in self._gates.get(waiting.pop(), ()):
                other = gate.other
                if other is not None and other.spot.room not in found and gate.door not in locked:
                    found.add(other.spot.room)
                    waiting.append(other.spot.room)
        self._reachable = found, locked
        return found

    def reachable(self, targets: AbstractSet[str], room: str, locked: frozenset[str] = frozenset()) -> set[str]:
        """Return those of *targets* to which a way leads from *room*."""
        rooms = self.reachable_rooms(room, locked)
        placed = targets & self._targets.keys()
        if all(one in rooms for one, there in self._in_room.items() if there):
            return placed
        return {one for one in placed if self._targets[one].room in rooms}

    def nearest(self, start: Spot, crossing: Crossing, wanted: AbstractSet[str] | None = None) -> Iterator[Way]:
        """Yield each target that can be reached, by the metres of its way and of the doors on it, nearest first.

        Args:
            start: Where the ways begin.
            crossing: What going through each door costs.
            wanted: The only targets to look for; None for all.
        """
        order = count()
        heap: list[tuple[float, str, int, _Step]] = []

        def push(step: _Step) -> None:
            name = step.to if isinstance(step.to, str) else ""
            heappush(heap, (step.path + step.extra, name, next(order), step))

        estimated = self._wanted_in(start.room, wanted)
        for target in estimated:
            push(_Step(target, self._air_distance(start, self._targets[target])))
        for gate in self._gates.get(start.room, ()):
            push(_Step(gate, self._inside(start, gate.spot, HALF_HOP)))
        done: set[str | _Gate] = set()
        while heap:
            step = heappop(heap)[-1]
            found, path, extra, doors = step
            if found in done:
                continue
            if not doors and found in estimated:
                estimated.discard(found)
                push(_Step(found, self._inside(start, self._targets[found], HALF_HOP)))
                continue
            done.add(found)
            if isinstance(found, str):
                yield Way(found, path, extra, doors)
            elif found.other is not None and not math.isinf(toll := crossing(found.door)):
                for further, one in self._behind(found.other, wanted):
                    push(_Step(one, path + further, extra + toll, (*doors, found.door)))

    def _wanted_in(self, room: str, wanted: AbstractSet[str] | None) -> set[str]:
        here = self._in_room.get(room, set())
        return set(here) if wanted is None else here & wanted

    def _behind(self, gate: _Gate, wanted: AbstractSet[str] | None) -> Iterator[tuple[float, str | _Gate]]:
        """Yield the other gates and the wanted targets in the room of *gate*, each with its distance."""
        yield from gate.ways
        for target in self._wanted_in(gate.spot.room, wanted):
            if target not in gate.targets:
                gate.targets[target] = self._inside(gate.spot, self._targets[target], HALF_HOP)
            yield gate.targets[target], target

    def _inside(self, start: Spot, end: Spot, otherwise: float) -> float:
        """Return metres between two places in one room, *otherwise* if one of them is not known."""
        paths = self._shapes.get(start.room)
        if paths is None or start.point is None or end.point is None:
            return self._air_distance(start, end, otherwise)
        return paths.distance(start.point, end.point)

    @staticmethod
    def _air_distance(start: Spot, end: Spot, otherwise: float = HALF_HOP) -> float:
        return otherwise if start.point is None or end.point is None else math.dist(start.point, end.point)
