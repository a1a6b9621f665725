"""Ways through the doors of a house, to the nearest targets first. Pure.

In a room without a polygon, and for a place known only by its room, half a hop of 2 m is counted.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from heapq import heappop, heappush
from typing import Final, NamedTuple, TypeAlias, final

from homebot.places.polygon import Point
from homebot.places.room_sight import RoomSight

HALF_HOP = 2.0
"""Metres between a door and a place in a room of unknown shape."""


class Spot(NamedTuple):
    """A place of a robot or a target.

    Attributes:
        point: Its position in metres; None if only the room is known.
    """

    room: str
    point: Point | None = None


class Doorway(NamedTuple):
    """A door, or a stair, between two rooms.

    Attributes:
        points: A point inside each room, 1 mm behind the threshold, for each way through it; empty if unknown. A wide
        opening has several ways.
    """

    name: str
    rooms: tuple[str, str]
    points: tuple[tuple[Point, Point], ...] = ()


class Way(NamedTuple):
    """The way to a target.

    Attributes:
        path: The length in metres.
        extra: Additional metres for doors on the way that are not open.
    """

    target: str
    path: float
    extra: float
    doors: tuple[str, ...]


Crossing: TypeAlias = Callable[[str], float]
"""The cost of going through a door, in metres: 0 if it is open, infinite if it is locked."""


_Goal: TypeAlias = Sequence[tuple[list[float], float, float]]

_START: Final = -1
"""The node of a way without any nodes yet."""

_LANDMARKS: Final = 8
_MAX_DIRECTED_TARGETS: Final = 10
"""The largest number of targets for which a search is directed, instead of going in all directions."""

_NOTHING: Final = frozenset[str]()


@final
class PathFinder:
    """Finds targets by the length of the way to them.

    Its nodes are the corners of rooms, plus one in each of the two rooms for each way through a door.
    """

    def __init__(self, rooms: Mapping[str, RoomSight]) -> None:
        self._rooms = rooms
        self._spots: list[Spot] = []
        self._doors: list[str] = []
        self._others: list[int] = []
        self._ways: list[list[tuple[float, int]] | None] = []
        self._nodes: dict[str, list[int]] = {}
        self._landmarks: list[list[float]] = []
        self._targets: dict[str, Spot] = {}
        self._in_room: dict[str, set[str]] = {}
        self._reachable: tuple[AbstractSet[str], frozenset[str]] = frozenset(), frozenset()
        for name, room in rooms.items():
            for corner in room.corners:
                self._add_node(Spot(name, corner), "", len(self._spots))

    def add(self, doorway: Doorway) -> None:
        """Add a door."""
        for points in doorway.points or ((None, None),):
            first = len(self._spots)
            for side in (0, 1):
                self._add_node(self._inside(Spot(doorway.rooms[side], points[side])), doorway.name, first + 1 - side)

    def look_around(self) -> Iterator[None]:
        """Precompute the visible nodes of each node before the first search; yield after each step."""
        for node in range(len(self._spots)):
            self._ways_from(node)
            yield
        source, away = 0, [math.inf] * len(self._spots)
        while len(self._landmarks) < _LANDMARKS and any(away):
            best: dict[int, float] = {}
            for _ in self._entered(self._spots[source], lambda _: 0.0, (), math.inf, best, {}):
                yield
            self._landmarks.append([best.get(node, math.inf) for node in range(len(away))])
            away = [*map(min, away, self._landmarks[-1])]
            source = away.index(max(away))

    def put(self, target: str, place: Spot) -> None:
        """Place a target, or move it."""
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
        """Return the targets that cannot be reached from *room*, except through *locked* doors."""
        known, though_locked = self._reachable
        if room not in known or locked != though_locked:
            reached, waiting = {room}, [room]
            while waiting:
                for node in self._nodes.get(waiting.pop(), ()):
                    other = self._spots[self._others[node]].room
                    if other not in reached and self._doors[node] not in locked:
                        reached.add(other)
                        waiting.append(other)
            known = reached
            self._reachable = reached, locked
        return set[str]().union(*(self._in_room[away] for away in self._in_room.keys() - known))

    def nearest(self, start: Spot, crossing: Crossing, wanted: AbstractSet[str] | None = None) -> Iterator[Way]:
        """Yield each reachable target, nearest first, by the length of its way plus the cost of the doors on it.

        Args:
            wanted: The only targets to look for; None for all.
        """
        came: dict[int, int] = {}
        ahead: list[tuple[float, str, int]] = []
        done: set[str] = set()
        begin = self._inside(start)

        def pop(until: float) -> Iterator[Way]:
            while ahead and ahead[0][0] <= until:
                metres, target, node = heappop(ahead)
                if target not in done and self._sees(self._spot(node, begin), self._targets[target]):
                    done.add(target)
                    yield self._way(target, metres, node, came, crossing)

        for bound, at, node in self._entered(begin, crossing, self._goal(wanted), math.inf, {}, came):
            yield from pop(bound)
            spot = self._spot(node, begin)
            here = self._in_room.get(spot.room, _NOTHING)
            for target in here if wanted is None else here & wanted:  # the straight line is the shortest
                heappush(ahead, (at + _metres(spot, self._targets[target], HALF_HOP), target, node))
        yield from pop(math.inf)

    def within(self, start: Spot, crossing: Crossing, wanted: AbstractSet[str], most: float) -> set[str]:
        """Return the *wanted* targets whose way, with its doors, costs at most *most* metres."""
        targets: set[str] = set()
        begin = self._inside(start)
        for _, at, node in self._entered(begin, crossing, (), most, {}, {}):
            spot = self._spot(node, begin)
            for target in (self._in_room.get(spot.room, _NOTHING) & wanted) - targets:
                place = self._targets[target]
                if at + _metres(spot, place, HALF_HOP) <= most and self._sees(spot, place):
                    targets.add(target)
        return targets

    def _spot(self, node: int, begin: Spot) -> Spot:
        return begin if node == _START else self._spots[node]

    def _way(self, target: str, metres: float, node: int, came: Mapping[int, int], crossing: Crossing) -> Way:
        """Return the way to a target from the last node on it; *came* has the previous node of each."""
        doors = []
        while node != _START:
            before = came[node]
            if before == self._others[node]:
                doors.append(self._doors[node])
            node = before
        extra = sum(map(crossing, doors))
        return Way(target, metres - extra, extra, tuple(reversed(doors)))

    def _entered(
        self, start: Spot, crossing: Crossing, goal: _Goal, most: float, best: dict[int, float], came: dict[int, int]
    ) -> Iterator[tuple[float, float, int]]:
        """Yield the start, and nodes where ways enter a room or turn in one, each as lower bound, metres and node.

        No further target is nearer than the bound, which never decreases: Dijkstra's search or, with a goal, A* with
        landmarks (Goldberg and Harrelson, "Computing the shortest path: A* search meets graph theory", 2005).

        Args:
            best: Filled with the shortest distance to each node, in metres.
            came: Filled with the previous node of each.
        """
        nodes: list[tuple[float, float, int]] = []
        limit = math.nextafter(most, math.inf)
        bound, at, before = 0.0, 0.0, _START
        while True:
            yield bound, at, before
            first = before == _START
            ways = self._seen(start, self._nodes.get(start.room, ()), HALF_HOP) if first else self._ways_from(before)
            for metres, next_node in ways:
                if (reached := at + metres) < best.get(next_node, limit):
                    best[next_node], came[next_node] = reached, before
                    if (bound := reached + _least_ahead(next_node, goal)) < limit:
                        heappush(nodes, (bound, reached, next_node))
            while nodes:
                bound, at, node = heappop(nodes)
                before = self._others[node]
                if at > best[node]:
                    continue
                if before == node:
                    break
                at += crossing(self._doors[node])
                if at < best.get(before, limit):
                    best[before], came[before] = at, node
                    break
            else:
                return

    def _goal(self, wanted: AbstractSet[str] | None) -> _Goal:
        """Return the distances of the nodes for each landmark, with the smallest and largest of a few targets."""
        spots = (
            []
            if wanted is None or len(wanted) > _MAX_DIRECTED_TARGETS
            else [*filter(None, map(self._targets.get, wanted))]
        )
        ways = [[*self._seen(spot, self._nodes.get(spot.room, ()), HALF_HOP)] for spot in spots]
        goal = []
        for known in self._landmarks if ways else ():
            away = [min((metres + known[node] for metres, node in way), default=math.inf) for way in ways]
            goal.append((known, min(away), max(away)))
        return goal

    def _add_node(self, spot: Spot, door: str, other: int) -> None:
        self._nodes.setdefault(spot.room, []).append(len(self._spots))
        self._spots.append(spot)
        self._doors.append(door)
        self._others.append(other)
        self._ways.append(None)

    def _ways_from(self, node: int) -> list[tuple[float, int]]:
        """Return the nodes in its room that are visible from a node, each with its distance."""
        if (ways := self._ways[node]) is None:
            spot = self._spots[node]
            others = (other for other in self._nodes[spot.room] if other != node)
            ways = self._ways[node] = [*self._seen(spot, others, 2 * HALF_HOP)]
        return ways

    def _seen(self, spot: Spot, nodes: Iterable[int], otherwise: float) -> Iterator[tuple[float, int]]:
        for node in nodes:
            if self._sees(spot, self._spots[node]):
                yield _metres(spot, self._spots[node], otherwise), node

    def _inside(self, place: Spot) -> Spot:
        """Return *place*, or the nearest place inside its room."""
        room = self._rooms.get(place.room)
        return place if room is None or place.point is None else Spot(place.room, room.inside(place.point))

    def _sees(self, start: Spot, end: Spot) -> bool:
        room = self._rooms.get(start.room)
        return room is None or start.point is None or end.point is None or room.sees(start.point, end.point)


def _least_ahead(node: int, goal: _Goal) -> float:
    """Return a lower bound of the way from a node to a goal, in metres."""
    ahead = 0.0
    for known, nearest, farthest in goal:
        away = known[node]
        if nearest - away > ahead:
            ahead = nearest - away
        elif away - farthest > ahead:
            ahead = away - farthest
    return ahead


def _metres(start: Spot, end: Spot, otherwise: float) -> float:
    """Return the straight distance between two places in metres, *otherwise* if one is unknown."""
    return otherwise if start.point is None or end.point is None else math.dist(start.point, end.point)
