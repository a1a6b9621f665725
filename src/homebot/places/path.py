"""Ways through the doors of a house, to the nearest targets first. Pure.

In a room without a polygon, and to a place in a room that is not known more exactly, half a hop of 2 m is counted.
"""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from dataclasses import dataclass, field
from heapq import heappop, heappush
from itertools import count
from typing import NamedTuple, Protocol, TypeAlias, final

from homebot.places.polygon import Point

__all__ = ["HALF_HOP", "Doorway", "PathFinder", "Paths", "Spot", "Way"]

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


class Paths(Protocol):
    """Ways inside a room."""

    def distance(self, start: Point, end: Point) -> float:
        """Return metres between two points."""


@dataclass(slots=True, eq=False, repr=False)
class _Gate:
    """One way through a door, as seen from one of its rooms.

    Attributes:
        other: The same way, as seen from the other room.
        near: The targets in the room, by distance; None until it is asked for.
    """

    door: str
    room: str
    point: Point | None
    other: _Gate | None = None
    ways: list[tuple[float, _Gate]] = field(default_factory=list)
    near: list[tuple[float, str]] | None = None


class _Step(NamedTuple):
    """A settled gate: how far it is, and through which doors."""

    path: float
    extra: float
    doors: tuple[str, ...]


@final
class PathFinder:
    """Finds targets by the length of the way to them.

    Args:
        shapes: The paths inside each room that has a polygon.
        doorways: The doors.
    """

    def __init__(self, shapes: Mapping[str, Paths], doorways: Iterable[Doorway]) -> None:
        self._shapes = shapes
        self._gates: dict[str, list[_Gate]] = {}
        self._targets: dict[str, Spot] = {}
        self._in_room: dict[str, set[str]] = {}
        self._reachable: dict[tuple[str, frozenset[str]], AbstractSet[str]] = {}
        for doorway in doorways:
            self._add(doorway)
        for gates in self._gates.values():
            for gate in gates:
                gate.ways = [
                    (self._inside(gate.room, gate.point, one.point, 2 * HALF_HOP), one)
                    for one in gates
                    if one is not gate
                ]

    def put(self, target: str, place: Spot) -> None:
        """Spot a target, or move it."""
        if self._targets.get(target) == place:
            return
        self.discard(target)
        self._targets[target] = place
        self._in_room.setdefault(place.room, set()).add(target)
        for gate in self._gates.get(place.room, ()):
            if gate.near is not None:
                insort(gate.near, (self._inside(place.room, gate.point, place.point, HALF_HOP), target))

    def discard(self, target: str) -> None:
        """Remove a target."""
        place = self._targets.pop(target, None)
        if place is not None:
            self._in_room[place.room].discard(target)
            for gate in self._gates.get(place.room, ()):
                gate.near = None

    def place_of(self, target: str) -> Spot | None:
        """Return the place of a target."""
        return self._targets.get(target)

    def reachable_rooms(self, room: str, locked: frozenset[str] = frozenset()) -> AbstractSet[str]:
        """Return the rooms to which a way leads from *room*, that itself included, but for the *locked* doors."""
        known = self._reachable.get((room, locked))
        if known is not None:
            return known
        found, waiting = {room}, [room]
        while waiting:
            for gate in self._gates.get(waiting.pop(), ()):
                other = gate.other
                if other is not None and other.room not in found and gate.door not in locked:
                    found.add(other.room)
                    waiting.append(other.room)
        self._reachable = {(room, locked): found}
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
        order = count()  # ties are broken by the order in which they were found
        heap: list[tuple[float, int, _QueueEntry]] = []

        def push(found: _QueueEntry) -> None:
            heappush(heap, (found.step.path + found.step.extra, next(order), found))

        here_too: AbstractSet[str] = self._in_room.get(start.room, set())
        for target in sorted(here_too if wanted is None else here_too & wanted):
            point = self._targets[target].point
            lower = math.dist(start.point, point) if start.point is not None and point is not None else HALF_HOP
            push(_QueueEntry(_Step(lower, 0.0, ()), target=target, is_estimate=True))
        for gate in self._gates.get(start.room, ()):
            push(_QueueEntry(_Step(self._inside(start.room, start.point, gate.point, HALF_HOP), 0.0, ()), gate=gate))
        settled: set[_Gate] = set()
        done: set[str] = set()
        while heap:
            _, _, found = heappop(heap)
            if found.gate is not None:
                if found.gate not in settled:
                    settled.add(found.gate)
                    self._leave(found.gate, found.step, crossing, wanted, push)
                continue
            if found.near:
                _push_next(found, found.rank + 1, wanted, push)
            if found.target in done:
                continue
            if found.is_estimate:
                exact = self._inside(start.room, start.point, self._targets[found.target].point, HALF_HOP)
                push(_QueueEntry(_Step(exact, 0.0, ()), target=found.target))
                continue
            done.add(found.target)
            yield Way(found.target, found.step.path, found.step.extra, found.step.doors)

    def _leave(
        self,
        gate: _Gate,
        step: _Step,
        crossing: Crossing,
        wanted: AbstractSet[str] | None,
        push: Callable[[_QueueEntry], None],
    ) -> None:
        """Go through *gate*: to the targets of the room behind it, and to the gates of that room."""
        extra = crossing(gate.door)
        if gate.other is None or math.isinf(extra):
            return
        entered = _Step(step.path, step.extra + extra, (*step.doors, gate.door))
        _push_next(_QueueEntry(entered, near=self._near(gate.other), entered=entered), 0, wanted, push)
        for distance, further in gate.other.ways:
            push(_QueueEntry(_Step(entered.path + distance, entered.extra, entered.doors), gate=further))

    def _near(self, gate: _Gate) -> list[tuple[float, str]]:
        if gate.near is None:
            gate.near = sorted(
                (self._inside(gate.room, gate.point, self._targets[target].point, HALF_HOP), target)
                for target in self._in_room.get(gate.room, ())
            )
        return gate.near

    def _inside(self, room: str, start: Point | None, end: Point | None, otherwise: float) -> float:
        """Return metres between two points of a room, *otherwise* if one of them is not known."""
        if start is None or end is None:
            return otherwise
        paths = self._shapes.get(room)
        return math.dist(start, end) if paths is None else paths.distance(start, end)

    def _add(self, doorway: Doorway) -> None:
        first, second = doorway.rooms
        for here, there in doorway.points or ((None, None),):
            gate = _Gate(doorway.name, first, here)
            gate.other = _Gate(doorway.name, second, there, gate)
            self._gates.setdefault(first, []).append(gate)
            self._gates.setdefault(second, []).append(gate.other)


class _QueueEntry(NamedTuple):
    """An entry of the queue: a gate, a target of the own room, or the next target behind a gate."""

    step: _Step
    gate: _Gate | None = None
    target: str = ""
    is_estimate: bool = False
    near: Sequence[tuple[float, str]] = ()
    entered: _Step = _Step(0.0, 0.0, ())
    rank: int = 0


def _push_next(
    found: _QueueEntry, rank: int, wanted: AbstractSet[str] | None, push: Callable[[_QueueEntry], None]
) -> None:
    """Push the next wanted target behind the gate of *found*, from the one of *rank* on."""
    near = found.near
    while rank < len(near) and wanted is not None and near[rank][1] not in wanted:
        rank += 1
    if rank < len(near):
        distance, target = near[rank]
        path, extra, doors = found.entered
        push(_QueueEntry(_Step(path + distance, extra, doors), None, target, False, near, found.entered, rank))  # noqa: FBT003
