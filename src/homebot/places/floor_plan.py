"""The floor plan of a house: the room at a point, and ways through doors. Pure; loaded with the first polygon."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple, final

from homebot.errors import ConfigError, UsageError
from homebot.places.facts import Position
from homebot.places.path import Doorway, PathFinder, Spot
from homebot.places.plan import STAIRS, HouseDoor, HousePlan, HouseRoom
from homebot.places.polygon import Point, Polygon
from homebot.places.room_paths import RoomPaths
from homebot.places.room_shapes import RoomAt, RoomShape, RoomShapes
from homebot.support.folding import fold

__all__ = ["HYSTERESIS", "SURE", "FloorPlan", "RoomChance"]

HYSTERESIS = 0.2
"""Metres that a robot must be away from its last room, to be in another one."""

SURE = 0.6
"""The probability from which one room is named for a position with an error."""

_REACH = 0.3
"""Metres that a door may be away from each of its rooms."""

_WIDE = 1.2
_STEP = 0.6
_CERTAIN = 3.0
"""Standard deviations from the border of a room from which it is certain."""

_COUNT = 64
_TURN = math.pi * (3 - math.sqrt(5))


def _sample(index: int) -> Point:
    """Return one of the fixed points that stand for the standard normal distribution, all equally probable."""
    radius, angle = math.sqrt(-2 * math.log(1 - (index + 0.5) / _COUNT)), index * _TURN
    return radius * math.cos(angle), radius * math.sin(angle)


_SAMPLES = tuple(map(_sample, range(_COUNT)))


class RoomChance(NamedTuple):
    """A room that a robot may be in.

    Attributes:
        room: The room; empty for none.
        probability: From 0 to 1.
    """

    room: str
    probability: float


@final
class FloorPlan:
    """The rooms and doors of a house in the plane.

    Args:
        plan: The rooms and doors.

    Attributes:
        plan: Likewise.
        shapes: The areas of rooms.

    Raises:
        ConfigError: An area is none, or a door is not at both its rooms; names the key and the value.
    """

    __slots__ = ("_areas", "_levels", "_paths", "plan", "shapes")

    def __init__(self, plan: HousePlan) -> None:
        self.plan = plan
        self._areas = {room.name: _polygons(room, plan.source) for room in plan.rooms if room.polygons}
        self.shapes = RoomShapes(
            RoomShape(room.name, room.floor, area) for room in plan.rooms for area in self._areas.get(room.name, ())
        )
        self._levels = {fold(shape.floor): shape.floor for shape in self.shapes.shapes}
        self._paths: dict[str, RoomPaths | _SeveralPaths] | None = None
        self._check_doors()

    @staticmethod
    @lru_cache(maxsize=2)
    def of(plan: HousePlan) -> FloorPlan:
        """Return the floor plan of *plan*, the same for the same plan."""
        return FloorPlan(plan)

    def room_at(self, x: float, y: float, floor: str = "", last: str = "") -> RoomAt | None:
        """Return the room that holds a point, else the nearest within 0.5 m.

        Args:
            x: Metres.
            y: Metres.
            floor: The floor; may be empty where only one has areas.
            last: The room before, which is left only by more than 0.2 m; empty for none.
        """
        level = self.level(floor)
        found = self.shapes.room_at(x, y, level)
        if not last or (found is not None and found.room == last):
            return found
        room = self.plan.room(last)
        if room is None or room.floor != level or room.name not in self._areas:
            return found
        distance = self.distance(room.name, x, y)
        return RoomAt(room.name, is_nearest=True, distance=distance) if distance <= HYSTERESIS else found

    def rooms_of(self, x: float, y: float, covariance: Sequence[float], floor: str = "") -> tuple[RoomChance, ...]:
        """Return the rooms of an uncertain position, the likeliest first.

        Args:
            x: Metres.
            y: Metres.
            covariance: The 36 numbers of a ROS pose, row by row, in square metres.
            floor: As for :meth:`room_at`.
        """
        xx, xy, yy = covariance[0], (covariance[1] + covariance[6]) / 2, covariance[7]
        largest = math.sqrt(max(0.0, (xx + yy) / 2 + math.hypot((xx - yy) / 2, xy)))
        level = self.level(floor)
        here = self.shapes.room_at(x, y, level)
        if here is not None and not here.is_nearest and self._border(x, y, level) > _CERTAIN * largest:
            return (RoomChance(here.room, 1.0),)
        a = math.sqrt(max(0.0, xx))
        b = xy / a if a else 0.0
        c = math.sqrt(max(0.0, yy - b * b))
        counts: dict[str, int] = {}
        for u, v in _SAMPLES:
            found = self.shapes.room_at(x + a * u, y + b * u + c * v, level)
            room = "" if found is None else found.room
            counts[room] = counts.get(room, 0) + 1
        ordered = sorted(counts.items(), key=lambda one: (-one[1], one[0]))
        return tuple(RoomChance(room, count / _COUNT) for room, count in ordered)

    def level(self, floor: str) -> str:
        """Return *floor* as the plan spells it; for an empty one the sole floor that has areas."""
        if not floor and len(self._levels) == 1:
            return next(iter(self._levels.values()))
        return self._levels.get(fold(floor), floor)

    def distance(self, room: str, x: float, y: float) -> float:
        """Return metres from a point to a room, 0 inside; infinite for a room without an area."""
        areas = self._areas.get(room, ())
        return min((0.0 if one.contains(x, y) else one.border_distance(x, y) for one in areas), default=math.inf)

    def centre_of(self, room: str) -> Position | None:
        """Return a position that stands for a room, with half its diagonal as the error; None without an area."""
        if room not in self._areas:
            return None
        area = max(self._areas[room], key=lambda one: one.area)
        x, y = area.nearest_inside(*area.centroid())
        box = area.box
        found = self.plan.room(room)
        error = math.dist((box.left, box.bottom), (box.right, box.top)) / 2
        return Position(x, y, "" if found is None else found.floor, error, "room")

    def place_of(self, position: Position, room: str = "") -> Spot | None:
        """Return the place of a position, for a :class:`PathFinder`; None if it is in no room.

        Args:
            position: The position.
            room: The room, if it is stated; of one without an area, or far away, the room alone counts.
        """
        point = position.x, position.y
        if room:
            known = self.plan.room(room)
            name = room if known is None else known.name
            return Spot(name, point if self.distance(name, *point) <= position.error + HYSTERESIS else None)
        found = self.room_at(*point, position.floor)
        return None if found is None else Spot(found.room, point)

    def path_finder(self) -> PathFinder:
        """Return a new finder of ways, without targets."""
        if self._paths is None:
            self._paths = {room: _paths(areas) for room, areas in self._areas.items()}
        return PathFinder(self._paths, self.doorways())

    def doorways(self) -> Iterator[Doorway]:
        """Yield the ways through each door."""
        for door in self.plan.doors:
            first, second = (self._areas.get(room, ()) for room in door.rooms)
            ends = _ends(door, first or second)
            points = [(_nearest(first, one), _nearest(second, one)) for one in _crossings(ends)]
            yield Doorway(door.name, door.rooms, tuple(points))

    def cost_of(self, door: HouseDoor) -> float:
        """Return the metres that an open door counts: those stated, or of stairs between two floors."""
        if door.cost is not None:
            return door.cost
        first, second = map(self.plan.room, door.rooms)
        return STAIRS if first is not None and second is not None and first.floor != second.floor else 0.0

    def overlaps(self) -> Iterator[tuple[str, str, float]]:
        """Yield each two rooms that overlap by more than 0.1 m² without one being inside the other, and the area."""
        from homebot.places.overlap import overlap_area  # noqa: PLC0415 - for checks alone

        shapes = sorted(self.shapes.shapes, key=lambda one: one.polygon.box.left)
        for index, one in enumerate(shapes):
            for other in shapes[index + 1 :]:
                if other.polygon.box.left >= one.polygon.box.right:
                    break
                if one.floor == other.floor and one.room != other.room:
                    area = overlap_area(one.polygon, other.polygon)
                    smaller = min(one.polygon.area, other.polygon.area)
                    if _LEAST_OVERLAP < area < smaller - _LEAST_OVERLAP:
                        yield one.room, other.room, area

    def _check_doors(self) -> None:
        for door in self.plan.doors:
            known = [room for room in door.rooms if room in self._areas] if door.position else []
            for room in known:
                away = self.distance(room, *_crossings(_ends(door, self._areas[known[0]]))[0])
                if away > _REACH:
                    reason = f"is {away:.2f} m from {room}; {_REACH} m is the limit"
                    raise ConfigError(self.plan.source, f"places.doors.{door.name}.position", reason)

    def _border(self, x: float, y: float, level: str) -> float:
        """Return metres from a point to the nearest border of any room on a floor."""
        near = (one.polygon for one in self.shapes.near(x, y, level))
        return min((one.border_distance(x, y) for one in near), default=math.inf)


_LEAST_OVERLAP = 0.1


@final
class _SeveralPaths:
    """Ways in a room of several areas: between two of them a straight line counts."""

    def __init__(self, areas: Sequence[Polygon]) -> None:
        self._paths = [RoomPaths(area) for area in areas]

    def distance(self, start: Point, end: Point) -> float:
        """Return metres between two points."""
        for one in self._paths:
            if one.polygon.contains(*start) and one.polygon.contains(*end):
                return one.distance(start, end)
        return math.dist(start, end)


def _paths(areas: Sequence[Polygon]) -> RoomPaths | _SeveralPaths:
    return RoomPaths(areas[0]) if len(areas) == 1 else _SeveralPaths(areas)


def _polygons(room: HouseRoom, source: str) -> tuple[Polygon, ...]:
    try:
        return tuple(Polygon(rings[0] if rings else (), rings[1:]) for rings in room.polygons)
    except UsageError as exc:
        raise ConfigError(source, f"places.rooms.{room.name}.polygon", str(exc)) from exc


def _nearest(areas: Sequence[Polygon], point: Point) -> Point:
    """Return the point of a room that is nearest, 1 mm inside."""
    inside = [one.nearest_inside(*point) for one in areas]
    return min(inside, key=lambda one: math.dist(one, point), default=point)


def _ends(door: HouseDoor, areas: Sequence[Polygon]) -> tuple[Point, ...]:
    """Return the two ends of a door; of one with a centre along the nearest wall."""
    if len(door.position) != 1 or not areas:
        return door.position
    x, y = door.position[0]
    area = min(areas, key=lambda one: one.border_distance(x, y))
    (x1, y1), (x2, y2) = area.nearest_edge(x, y)
    share = door.width / 2 / math.dist((x1, y1), (x2, y2))
    dx, dy = (x2 - x1) * share, (y2 - y1) * share
    return (x - dx, y - dy), (x + dx, y + dy)


def _crossings(ends: tuple[Point, ...]) -> list[Point]:
    """Return the middle of a door, of one wider than 1.2 m points along it: the nearest to the middle first."""
    if len(ends) < 2:
        return list(ends)
    (x1, y1), (x2, y2) = ends
    width = math.dist(*ends)
    count = math.ceil(width / _STEP) if width > _WIDE else 1
    shares = sorted(((2 * index + 1) / (2 * count) for index in range(count)), key=lambda one: abs(one - 0.5))
    return [(x1 + (x2 - x1) * share, y1 + (y2 - y1) * share) for share in shares]
