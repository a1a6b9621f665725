"""The plan of a house: rooms on floors in one home, and the doors between rooms. Pure.

Areas are nested in three levels: the home, its floors, and the rooms on them. A name belongs to one level alone,
ignoring case and accents, so no area can contain itself.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple, TypeAlias, final

from homebot.errors import ConfigError
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.places.floor_plan import FloorPlan

__all__ = [
    "MAX_ROOMS",
    "NO_AREAS",
    "OUTSIDE",
    "STAIRS",
    "WIDTH",
    "HouseDoor",
    "HousePlan",
    "HouseRoom",
    "Point",
    "Rings",
    "door_name",
]

MAX_ROOMS = 1000
"""Rooms of one house."""

OUTSIDE = "outside"
"""A room to which doors may lead, whether or not it is in the plan."""

NO_AREAS: tuple[str, ...] = ()

WIDTH = 0.8
"""Metres of a door of which only the centre is stated."""

STAIRS = 10.0
"""Metres that a way between two floors counts, where no cost is stated."""

_ROOMS = "places.rooms"
_DOORS = "places.doors"

Point: TypeAlias = tuple[float, float]
"""A point on a floor: x and y in metres."""

Rings: TypeAlias = tuple[tuple[Point, ...], ...]
"""The corners of a polygon: its outer ring, then its holes."""


class HouseRoom(NamedTuple):
    """A room.

    Attributes:
        name: Its name.
        floor: The floor that it is on; empty where that is not stated.
        doors: The rooms that a door joins it to.
        polygons: Its area; empty where that is not known.
    """

    name: str
    floor: str = ""
    doors: tuple[str, ...] = ()
    polygons: tuple[Rings, ...] = ()


class HouseDoor(NamedTuple):
    """A door, an opening, or a stair, between two rooms.

    Attributes:
        name: Its name.
        rooms: The two rooms; one may be the outside.
        position: Its two ends, or its centre alone, in metres; empty where that is not known.
        width: Metres; only for a centre.
        contact: The device that reports whether it is open; empty for none.
        lock: The device that locks it; empty for none.
        cost: Metres that going through it counts, besides the way; those of stairs between two floors if None.
    """

    name: str
    rooms: tuple[str, str]
    position: tuple[Point, ...] = ()
    width: float = WIDTH
    contact: str = ""
    lock: str = ""
    cost: float | None = None

    @property
    def is_plain(self) -> bool:
        """True if its rooms alone are stated."""
        return self == HouseDoor(self.name, self.rooms)


@final
class HousePlan:
    """The areas of one home.

    Args:
        home: The name of the home.
        rooms: Its rooms. Of several entries for one room, a later floor or area replaces an earlier one, and doors
            add up.
        source: Where they are from, for messages.
        doors: The doors of which more is stated; a later one replaces an earlier one of the same name.

    Attributes:
        home: The name of the home.
        source: Where the rooms are from, for messages.
        rooms: Its rooms, with each door at both its ends.
        floors: The names of its floors.
        doors: All its doors, those of rooms too of which nothing else is stated.

    Raises:
        ConfigError: A name is used on two levels, a door leads to no room, or there are too many rooms; names the key
            and the value.
    """

    __slots__ = ("__weakref__", "_in_home", "_located", "_rooms", "doors", "floors", "home", "rooms", "source")

    def __init__(
        self, home: str, rooms: Iterable[HouseRoom] = (), source: str = "places", doors: Iterable[HouseDoor] = ()
    ) -> None:
        self.home = home
        self.source = source
        stated = tuple({fold(door.name): door for door in doors}.values())
        joined = _joined(rooms, source, stated)
        floors: dict[str, str] = {}
        for room in joined.values():
            if room.floor:
                floors.setdefault(fold(room.floor), room.floor)
        self._rooms = {key: one._replace(floor=floors.get(fold(one.floor), "")) for key, one in joined.items()}
        self.rooms = tuple(self._rooms.values())
        self.floors = tuple(floors.values())
        self._check_levels(source)
        self._check_doors(source, stated)
        self._in_home = (home,)
        on_floor = {"": self._in_home, **{key: (floor, home) for key, floor in floors.items()}}
        self._located = {
            fold(home): (home, NO_AREAS),
            **{key: (floor, self._in_home) for key, floor in floors.items()},
            **{key: (room.name, on_floor[fold(room.floor)]) for key, room in self._rooms.items()},
        }
        self.doors = self._with_plain(stated)

    @property
    def floor_plan(self) -> FloorPlan:
        """The rooms and doors in the plane."""
        from homebot.places.floor_plan import FloorPlan  # noqa: PLC0415 - with the first polygon

        return FloorPlan.of(self)

    def check_geometry(self) -> None:
        """Check the areas and the positions of doors; those stated from outside are, before they are used.

        Raises:
            ConfigError: An area is none, or a door is not at both its rooms; names the key and the value.
        """
        if any(room.polygons for room in self.rooms) or any(door.position for door in self.doors):
            _ = self.floor_plan

    def locate(self, area: str) -> tuple[str, tuple[str, ...]]:
        """Return *area* as the plan spells it, and the areas that it is in, the innermost first: its floor, the home.

        A room that the plan does not have is in the home.
        """
        return self._located.get(fold(area)) or (area, self._in_home)

    def room(self, name: str) -> HouseRoom | None:
        """Return the room of that name, ignoring case and accents, or None."""
        return self._rooms.get(fold(name))

    def with_rooms(self, rooms: Iterable[HouseRoom], source: str, doors: Iterable[HouseDoor] = ()) -> HousePlan:
        """Return the plan with further *rooms* and *doors*, which win where both state a floor, an area or a door.

        Raises:
            ConfigError: As for the class, and :meth:`check_geometry`.
        """
        plan = HousePlan(self.home, (*self.rooms, *rooms), source, (*self.doors, *doors))
        plan.check_geometry()
        return plan

    def _check_levels(self, source: str) -> None:
        home = fold(self.home)
        for key, room in self._rooms.items():
            if key == home:
                raise ConfigError(source, f"{_ROOMS}.{room.name}", "is the name of the home")
            floor = fold(room.floor)
            if floor == home:
                raise ConfigError(source, f"{_ROOMS}.{room.name}.floor", f"{room.floor!r} is the name of the home")
            if floor in self._rooms or floor == OUTSIDE:
                raise ConfigError(source, f"{_ROOMS}.{room.name}.floor", f"{room.floor!r} is a room")

    def _check_doors(self, source: str, stated: Iterable[HouseDoor]) -> None:
        for one in stated:
            for name, other in (one.rooms, one.rooms[::-1]):
                self._check_door(name, other, source, f"{_DOORS}.{one.name}.rooms")
        for room in self.rooms:
            for door in room.doors:
                self._check_door(room.name, door, source, f"{_ROOMS}.{room.name}.doors")

    def _check_door(self, room: str, to: str, source: str, key: str) -> None:
        known = [one.name for one in self.rooms]
        if fold(to) == fold(room):
            raise ConfigError(source, key, f"{to!r} is the room itself")
        if fold(to) not in self._rooms and fold(to) != OUTSIDE:
            hint = did_you_mean(to, known, f"rooms are {', '.join(known)}")
            raise ConfigError(source, key, f"there is no room {to!r}; {hint}")

    def _with_plain(self, stated: Iterable[HouseDoor]) -> tuple[HouseDoor, ...]:
        """Return the doors, each with its rooms as the plan spells them, and one for all rooms that are joined."""
        found = [door._replace(rooms=(self.locate(door.rooms[0])[0], self.locate(door.rooms[1])[0])) for door in stated]
        known = {frozenset(map(fold, door.rooms)) for door in found if not door.is_plain}
        found = [door for door in found if not door.is_plain]
        for room in self.rooms:
            for other in room.doors:
                ends = frozenset((fold(room.name), fold(other)))
                if ends not in known:
                    known.add(ends)
                    found.append(HouseDoor(door_name((room.name, other)), (room.name, other)))
        return tuple(found)


def door_name(rooms: tuple[str, str]) -> str:
    """Return the name of a door of which no name is stated."""
    return "–".join(rooms)  # noqa: RUF001 - an en dash joins the ends of a way


def _joined(rooms: Iterable[HouseRoom], source: str, stated: Iterable[HouseDoor]) -> dict[str, HouseRoom]:
    """Return each room once, by its folded name, with each door at both its ends."""
    found: dict[str, HouseRoom] = {}
    for room in rooms:
        known = found.get(fold(room.name))
        if known is not None:
            room = known._replace(  # noqa: PLW2901
                floor=room.floor or known.floor,
                doors=(*known.doors, *room.doors),
                polygons=room.polygons or known.polygons,
            )
        found[fold(room.name)] = room
    if len(found) > MAX_ROOMS:
        raise ConfigError(source, _ROOMS, f"has {len(found):,} rooms; {MAX_ROOMS:,} is the limit")
    ends = [(room.name, name) for room in found.values() for name in room.doors]
    doors = _doors_of(found, (*ends, *(door.rooms for door in stated)))
    return {key: room._replace(doors=doors[key]) for key, room in found.items()}


def _doors_of(rooms: Mapping[str, HouseRoom], ends: Iterable[tuple[str, str]]) -> dict[str, tuple[str, ...]]:
    """Return the rooms behind the doors of each room, as they are spelled, by folded name."""
    doors: dict[str, dict[str, str]] = {key: {} for key in rooms}
    for first, second in ends:
        for here, there in ((fold(first), second), (fold(second), first)):
            if here in doors:
                doors[here].setdefault(fold(there), rooms[fold(there)].name if fold(there) in rooms else there)
    return {key: tuple(found.values()) for key, found in doors.items()}
