"""The plan of a house: rooms on floors in one home, and the doors between rooms. Pure.

Areas are nested in three levels: the home, its floors, and the rooms on them. A name belongs to only one level,
ignoring case and accents, so no area can contain itself.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from typing import NamedTuple, TypeAlias, final

from homebot.errors import ConfigError
from homebot.support.folding import fold
from homebot.support.names import no_such

MAX_ROOMS = 1000
"""The limit of rooms of one house."""

OUTSIDE = "outside"
"""A room to which doors may lead even if it is not in the plan."""

NO_AREAS: tuple[str, ...] = ()

WIDTH = 0.8
"""The default width of a door with only a centre, in metres."""

STAIRS = 10.0
"""The default cost of a way between two floors, in metres."""

_ROOMS = "places.rooms"
_DOORS = "places.doors"

Point: TypeAlias = tuple[float, float]
"""A point on a floor: x and y in metres."""

Rings: TypeAlias = tuple[tuple[Point, ...], ...]
"""The corners of a polygon: its outer ring, then its holes."""


class HouseRoom(NamedTuple):
    """A room.

    Attributes:
        floor: Its floor; empty if it is not stated.
        doors: The rooms to which a door connects it.
        polygons: Its area; empty if unknown.
        source: The robot whose map the area comes from; empty for the owner.
    """

    name: str
    floor: str = ""
    doors: tuple[str, ...] = ()
    polygons: tuple[Rings, ...] = ()
    source: str = ""


class HouseDoor(NamedTuple):
    """A door, an opening, or a stair, between two rooms.

    Attributes:
        rooms: The two rooms; one may be the outside.
        position: Its two ends, or only its centre, in metres; empty if unknown.
        width: Metres; only with a centre.
        contact: The device that reports whether it is open; empty for none.
        lock: The device that locks it; empty for none.
        cost: The cost of going through it, in metres; None for that of stairs between two floors.
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
        """True if only its rooms are stated."""
        return self == HouseDoor(self.name, self.rooms)


@final
class HousePlan:
    """The areas of one home.

    Args:
        rooms: Its rooms. If a room has several entries, a later floor or area replaces an earlier one, and doors are
            combined.
        doors: The doors with further facts; a later one replaces an earlier one of the same name.

    Attributes:
        rooms: Its rooms, with each door at both ends.
        doors: All its doors, including those without further facts.

    Raises:
        ConfigError: A name is used on two levels, a door leads to no room, or there are too many rooms; names the key
            and the value.
    """

    def __init__(
        self, home: str, rooms: Iterable[HouseRoom] = (), source: str = "places", doors: Iterable[HouseDoor] = ()
    ) -> None:
        self.home = home
        self.source = source
        self._rooms = _merge(rooms, source)
        self._check_levels(source)
        self.doors = self._join({fold(door.name): door for door in doors}.values())
        self.rooms = tuple(self._rooms.values())
        self.has_areas = any(room.polygons for room in self.rooms)
        floors = {fold(room.floor): room.floor for room in self.rooms if room.floor}
        self.floors = tuple(floors.values())
        self._in_home = (home,)
        on_floor = {"": self._in_home, **{key: (floor, home) for key, floor in floors.items()}}
        self._located = {
            fold(home): (home, NO_AREAS),
            **{key: (floor, self._in_home) for key, floor in floors.items()},
            **{key: (room.name, on_floor[fold(room.floor)]) for key, room in self._rooms.items()},
        }

    def locate(self, area: str) -> tuple[str, tuple[str, ...]]:
        """Return *area* in the plan's spelling, and the areas that contain it, innermost first: its floor, the home.

        A room that is not in the plan is in the home.
        """
        return self._located.get(fold(area)) or (area, self._in_home)

    def locate_on(self, area: str, floor: str) -> tuple[str, tuple[str, ...]]:
        """Locate the room *area*, on the announced *floor* if the plan states none; *floor* may be empty.

        A floor with the name of a room or the home is ignored.
        """
        name, outer = self.locate(area)
        key, level = fold(area), fold(floor)
        is_room = key in self._rooms or key not in self._located
        if not level or not is_room or outer != self._in_home or level in {*self._rooms, key, OUTSIDE}:
            return name, outer
        spelled, around = self.locate(floor)
        return name, (spelled, *around) if around else outer

    def room(self, name: str) -> HouseRoom | None:
        """Return the room of that name, ignoring case and accents, or None."""
        return self._rooms.get(fold(name))

    def with_rooms(self, rooms: Iterable[HouseRoom], source: str, doors: Iterable[HouseDoor] = ()) -> HousePlan:
        """Return the plan with further *rooms* and *doors*, which take precedence for floors, areas and doors."""
        return HousePlan(self.home, (*self.rooms, *rooms), source, (*self.doors, *doors))

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

    def _join(self, stated: Collection[HouseDoor]) -> tuple[HouseDoor, ...]:
        """Set the doors of all rooms; return the *stated* doors, and one for each further pair of connected rooms."""
        joined: dict[str, dict[str, str]] = {key: {} for key in self._rooms}
        plain: dict[frozenset[str], HouseDoor] = {}
        more = []
        for way, key in self._ways(stated):
            rooms = self._spelled(way.rooms, key), self._spelled(way.rooms[::-1], key)
            door = way._replace(name=way.name or door_name(rooms), rooms=rooms)
            for here, other in (rooms, rooms[::-1]):
                joined.get(fold(here), {}).setdefault(fold(other), other)
            if door.is_plain:
                plain.setdefault(frozenset(rooms), door)
            else:
                more.append(door)
        for door in more:
            plain.pop(frozenset(door.rooms), None)
        for key, room in self._rooms.items():
            self._rooms[key] = room._replace(doors=tuple(joined[key].values()))
        return (*more, *plain.values())

    def _ways(self, stated: Iterable[HouseDoor]) -> Iterator[tuple[HouseDoor, str]]:
        """Yield the doors of all rooms, then the *stated* ones, each with its key."""
        for room in self._rooms.values():
            for to in room.doors:
                yield HouseDoor("", (room.name, to)), f"{_ROOMS}.{room.name}.doors"
        for door in stated:
            yield door, f"{_DOORS}.{door.name}.rooms"

    def _spelled(self, rooms: tuple[str, str], key: str) -> str:
        """Return the first of the two *rooms* of a door in the plan's spelling."""
        name, other = rooms
        if fold(name) == fold(other):
            raise ConfigError(self.source, key, f"{name!r} is the room itself")
        if (room := self._rooms.get(fold(name))) is not None:
            return room.name
        if fold(name) != OUTSIDE:
            known = [room.name for room in self._rooms.values()]
            raise ConfigError(self.source, key, no_such("room", name, known))
        return OUTSIDE


def door_name(rooms: tuple[str, str]) -> str:
    """Return the name of an unnamed door."""
    return "–".join(rooms)  # noqa: RUF001 - an en dash joins the ends of a way


def _merge(rooms: Iterable[HouseRoom], source: str) -> dict[str, HouseRoom]:
    """Return each room once, by its folded name, with floors in their first spelling."""
    house_rooms: dict[str, HouseRoom] = {}
    for room in rooms:
        known = house_rooms.get(fold(room.name), room)
        house_rooms[fold(room.name)] = known._replace(
            floor=room.floor or known.floor,
            doors=(*known.doors, *room.doors),
            polygons=room.polygons or known.polygons,
            source=(room if room.polygons else known).source,
        )
    if len(house_rooms) > MAX_ROOMS:
        raise ConfigError(source, _ROOMS, f"has {len(house_rooms):,} rooms; {MAX_ROOMS:,} is the limit")
    floors: dict[str, str] = {}
    return {
        key: room._replace(floor=floors.setdefault(fold(room.floor), room.floor)) for key, room in house_rooms.items()
    }
