"""The floor plan of a house: the room at a point, and ways through doors. Pure; loaded for the first polygon."""

from __future__ import annotations

import math
from collections.abc import Generator, Mapping, Sequence
from functools import cached_property, lru_cache
from typing import NamedTuple, final

from homebot.errors import ConfigError, UsageError
from homebot.places.facts import Position
from homebot.places.path import Doorway, PathFinder, Spot
from homebot.places.plan import STAIRS, HouseDoor, HousePlan, HouseRoom
from homebot.places.polygon import Point, Polygon
from homebot.places.room_sight import RoomSight
from homebot.support.folding import fold

_HYSTERESIS = 0.2
"""Metres that a robot must be away from its last room to be in another one."""

_NEARBY = 0.5
"""Metres within which a point outside all rooms, in a wall or doorway, belongs to a room."""

_REACH = 0.3
"""The largest distance of a door from each of its rooms, in metres."""

_WIDE = 1.2
_STEP = 0.6
_MIN_OVERLAP = 0.1


class RoomAt(NamedTuple):
    """The room of a point.

    Attributes:
        is_nearest: Whether the point is in no room, and this is the nearest room.
    """

    room: str
    is_nearest: bool = False


class _Area(NamedTuple):
    """One polygon of a room; a room may have several."""

    size: float
    room: str
    floor: str
    polygon: Polygon


@final
class FloorPlan:
    """The rooms and doors of a house in the plane.

    Raises:
        ConfigError: An area is invalid, or a door is not at both its rooms; names the key and the value.
    """

    def __init__(self, plan: HousePlan) -> None:
        self.plan = plan
        self._polygons = {room.name: _polygons(room, plan.source) for room in plan.rooms if room.polygons}
        self._floors = {room.name: room.floor for room in plan.rooms if room.polygons}
        self._levels = {fold(floor): floor for floor in self._floors.values()}
        areas = (_Area(area.area, room, self._floors[room], area) for room in self._polygons for area in self._of(room))
        self._areas = sorted(areas, key=lambda area: area[:2])
        self._by_column: dict[tuple[str, int], list[_Area]] = {}
        for area in self._areas:
            box = area.polygon.box
            for column in range(math.floor(box.left - _NEARBY), math.floor(box.right + _NEARBY) + 1):
                self._by_column.setdefault((area.floor, column), []).append(area)
        for door in self.plan.doors:
            for crossing in self._crossings(door)[:1]:
                for side, point in zip(door.rooms, crossing, strict=True):
                    away = self.distance(side, *point) if side in self._polygons else 0.0
                    if away > _REACH:
                        reason = f"is {away:.2f} m from {side}; {_REACH} m is the limit"
                        raise ConfigError(self.plan.source, f"places.doors.{door.name}.position", reason)

    @staticmethod
    @lru_cache(maxsize=2)
    def of(plan: HousePlan) -> FloorPlan:
        """Return the floor plan of *plan*, cached for each plan."""
        return FloorPlan(plan)

    def room_at(self, x: float, y: float, floor: str = "", last: str = "") -> RoomAt | None:
        """Return the smallest room that contains a point, else the nearest within 0.5 m.

        Args:
            floor: The floor; may be empty if only one has areas.
            last: The previous room, which counts as left only after more than 0.2 m; empty for none.
        """
        near = self._near(x, y, floor)
        holding = next((area for area in near if area.polygon.contains(x, y)), None)
        if holding is not None and last in {"", holding.room}:
            return RoomAt(holding.room)
        distances = {area.room: self.distance(area.room, x, y) for area in near}
        away = distances.get(last, math.inf)
        if (away or holding is None or holding.polygon.border_distance(x, y)) <= _HYSTERESIS:
            return RoomAt(last, is_nearest=away > 0)
        return _nearest_room(distances) if holding is None else RoomAt(holding.room)

    def level(self, floor: str) -> str:
        """Return *floor* in the plan's spelling; if empty, the only floor that has areas."""
        if not floor and len(self._levels) == 1:
            return next(iter(self._levels.values()))
        return self._levels.get(fold(floor), floor)

    def distance(self, room: str, x: float, y: float) -> float:
        """Return the distance from a point to a room in metres, 0 inside; infinite for a room without an area."""
        areas = self._of(room)
        return min((0.0 if area.contains(x, y) else area.border_distance(x, y) for area in areas), default=math.inf)

    def centre_of(self, room: str) -> Position | None:
        """Return a representative position of a room, with half its diagonal as the error; None without an area."""
        area = max(self._of(room), key=lambda one: one.area, default=None)
        if area is None:
            return None
        x, y = area.nearest_inside(*area.centroid())
        box = area.box
        error = math.dist((box.left, box.bottom), (box.right, box.top)) / 2
        return Position(x, y, self._floors[room], error, "room")

    def place_of(self, position: Position, room: str = "") -> Spot | None:
        """Return the spot of a position, for a :class:`PathFinder`; None if it is in no room.

        Args:
            room: The room, if it is stated; if it has no area, or is far away, only the room counts.
        """
        point = position.x, position.y
        if room:
            name, _ = self.plan.locate(room)
            return Spot(name, point if self.distance(name, *point) <= position.error + _HYSTERESIS else None)
        at = self.room_at(*point, position.floor)
        return None if at is None else Spot(at.room, point)

    def rooms_beside(self, x: float, y: float, floor: str = "") -> list[str]:
        """Return the rooms that a door at a point may connect, nearest first."""
        distances = {area.room: self.distance(area.room, x, y) for area in self._near(x, y, floor)}
        return sorted(
            (room for room in distances if distances[room] <= _REACH), key=lambda room: (distances[room], room)
        )

    def path_finder(self) -> Generator[None, None, PathFinder]:
        """Return a new path finder without targets; yields after each step, so that others have their turn."""
        sights = {}
        for room, areas in self._polygons.items():
            sights[room] = RoomSight(*areas)
            yield
        finder = PathFinder(sights)
        for door in self.plan.doors:
            finder.add(self.doorway(door))
            yield
        yield from finder.look_around()
        return finder

    def is_stairs(self, door: HouseDoor) -> bool:
        """Return whether a door connects two floors."""
        first, second = map(self.plan.room, door.rooms)
        return first is not None and second is not None and first.floor != second.floor

    def cost_of(self, door: HouseDoor) -> float:
        """Return the cost of an open door in metres: the stated one, or that of stairs between two floors."""
        if door.cost is not None:
            return door.cost
        return STAIRS if self.is_stairs(door) else 0.0

    @cached_property
    def overlaps(self) -> tuple[tuple[str, str, float], ...]:
        """The pairs of rooms that overlap by more than 0.1 m², neither inside the other, with the shared area."""
        overlaps = []
        areas = sorted(self._areas, key=lambda area: area.polygon.box.left)
        for index, area in enumerate(areas):
            for other in areas[index + 1 :]:
                if other.polygon.box.left >= area.polygon.box.right:
                    break
                if area.floor == other.floor and area.room != other.room:
                    overlaps.append((area.room, other.room, area.polygon.overlap(other.polygon)))
        return tuple(overlap for overlap in overlaps if overlap[2] > _MIN_OVERLAP)

    def _of(self, room: str) -> tuple[Polygon, ...]:
        return self._polygons.get(room, ())

    def _near(self, x: float, y: float, floor: str) -> list[_Area]:
        """Return the areas that may contain a point, or be within 0.5 m of it, smallest first."""
        areas = self._by_column.get((self.level(floor), math.floor(x)), ())
        return [area for area in areas if area.polygon.box.bottom - _NEARBY <= y <= area.polygon.box.top + _NEARBY]

    def doorway(self, door: HouseDoor) -> Doorway:
        """Return the ways through a door."""
        first, second = map(self._of, door.rooms)
        sides = [(_nearest(first, point), _nearest(second, other)) for point, other in self._crossings(door)]
        return Doorway(door.name, door.rooms, tuple(sides))

    def _crossings(self, door: HouseDoor) -> list[tuple[Point, Point]]:
        """Return the points at which a door is passed, in each of its two rooms; empty if unknown."""
        if self.is_stairs(door) and len(door.position) == 2:
            return [(door.position[0], door.position[1])]
        areas = self._of(door.rooms[0]) or self._of(door.rooms[1])
        return [(passage, passage) for passage in _passages(_ends(door, areas))]


def _polygons(room: HouseRoom, source: str) -> tuple[Polygon, ...]:
    try:
        return tuple(Polygon(rings[0] if rings else (), rings[1:]) for rings in room.polygons)
    except UsageError as exc:
        raise ConfigError(source, f"places.rooms.{room.name}.polygon", str(exc)) from exc


def _nearest(areas: Sequence[Polygon], point: Point) -> Point:
    """Return the nearest point of a room, 1 mm inside."""
    inside = [area.nearest_inside(*point) for area in areas]
    return min(inside, key=lambda one: math.dist(one, point), default=point)


def _ends(door: HouseDoor, areas: Sequence[Polygon]) -> tuple[Point, ...]:
    """Return the two ends of a door; for one with a centre, along the nearest wall."""
    if len(door.position) != 1 or not areas:
        return door.position
    x, y = door.position[0]
    area = min(areas, key=lambda area: area.border_distance(x, y))
    (x1, y1), (x2, y2) = area.nearest_edge(x, y)
    share = door.width / 2 / math.dist((x1, y1), (x2, y2))
    dx, dy = (x2 - x1) * share, (y2 - y1) * share
    return (x - dx, y - dy), (x + dx, y + dy)


def _passages(ends: tuple[Point, ...]) -> list[Point]:
    """Return the middle of a door; if it is wider than 1.2 m, points along it, nearest to the middle first."""
    if len(ends) < 2:
        return list(ends)
    (x1, y1), (x2, y2) = ends
    width = math.dist(*ends)
    count = math.ceil(width / _STEP) if width > _WIDE else 1
    shares = sorted(((2 * index + 1) / (2 * count) for index in range(count)), key=lambda one: abs(one - 0.5))
    return [(x1 + (x2 - x1) * share, y1 + (y2 - y1) * share) for share in shares]


def _nearest_room(distances: Mapping[str, float]) -> RoomAt | None:
    """Return the nearest room, given *distances* in metres; None if it is too far away."""
    room = min(distances, key=distances.__getitem__, default="")
    return RoomAt(room, is_nearest=True) if distances.get(room, math.inf) <= _NEARBY else None
