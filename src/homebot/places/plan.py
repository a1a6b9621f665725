"""The plan of a house: rooms on floors in one home, and the doors between rooms. Pure.

Areas are nested in three levels: the home, its floors, and the rooms on them. A name belongs to one level alone,
ignoring case and accents, so no area can contain itself.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple, final

from homebot.errors import ConfigError
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["MAX_ROOMS", "NO_AREAS", "OUTSIDE", "HousePlan", "HouseRoom"]

MAX_ROOMS = 1000
"""Rooms of one house."""

OUTSIDE = "outside"
"""A room to which doors may lead, whether or not it is in the plan."""

NO_AREAS: tuple[str, ...] = ()

_ROOMS = "places.rooms"


class HouseRoom(NamedTuple):
    """A room.

    Attributes:
        name: Its name.
        floor: The floor that it is on; empty where that is not stated.
        doors: The rooms that a door joins it to.
    """

    name: str
    floor: str = ""
    doors: tuple[str, ...] = ()


@final
class HousePlan:
    """The areas of one home.

    Args:
        home: The name of the home.
        rooms: Its rooms. Of several entries for one room, a later floor replaces an earlier one, and doors add up.
        source: Where they are from, for messages.

    Attributes:
        home: The name of the home.
        rooms: Its rooms, with each door at both its ends.
        floors: The names of its floors.

    Raises:
        ConfigError: A name is used on two levels, a door leads to no room, or there are too many rooms; names the key
            and the value.
    """

    __slots__ = ("_in_home", "_located", "_rooms", "floors", "home", "rooms")

    def __init__(self, home: str, rooms: Iterable[HouseRoom] = (), source: str = "places") -> None:
        self.home = home
        joined = _joined(rooms, source)
        floors: dict[str, str] = {}
        for room in joined.values():
            if room.floor:
                floors.setdefault(fold(room.floor), room.floor)
        self._rooms = {key: one._replace(floor=floors.get(fold(one.floor), "")) for key, one in joined.items()}
        self.rooms = tuple(self._rooms.values())
        self.floors = tuple(floors.values())
        self._check_levels(source)
        self._check_doors(source)
        self._in_home = (home,)
        on_floor = {"": self._in_home, **{key: (floor, home) for key, floor in floors.items()}}
        self._located = {
            fold(home): (home, NO_AREAS),
            **{key: (floor, self._in_home) for key, floor in floors.items()},
            **{key: (room.name, on_floor[fold(room.floor)]) for key, room in self._rooms.items()},
        }

    def locate(self, area: str) -> tuple[str, tuple[str, ...]]:
        """Return *area* as the plan spells it, and the areas that it is in, the innermost first: its floor, the home.

        A room that the plan does not have is in the home.
        """
        return self._located.get(fold(area)) or (area, self._in_home)

    def room(self, name: str) -> HouseRoom | None:
        """Return the room of that name, ignoring case and accents, or None."""
        return self._rooms.get(fold(name))

    def with_rooms(self, rooms: Iterable[HouseRoom], source: str) -> HousePlan:
        """Return the plan with further *rooms*, which win where both state a floor.

        Raises:
            ConfigError: As for the class.
        """
        return HousePlan(self.home, (*self.rooms, *rooms), source)

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

    def _check_doors(self, source: str) -> None:
        known = [room.name for room in self.rooms]
        for key, room in self._rooms.items():
            for door in room.doors:
                if fold(door) == key:
                    raise ConfigError(source, f"{_ROOMS}.{room.name}.doors", f"{door!r} is the room itself")
                if fold(door) not in self._rooms and fold(door) != OUTSIDE:
                    hint = did_you_mean(door, known, f"rooms are {', '.join(known)}")
                    raise ConfigError(source, f"{_ROOMS}.{room.name}.doors", f"there is no room {door!r}; {hint}")


def _joined(rooms: Iterable[HouseRoom], source: str) -> dict[str, HouseRoom]:
    """Return each room once, by its folded name, with each door at both its ends."""
    found: dict[str, HouseRoom] = {}
    for room in rooms:
        known = found.get(fold(room.name))
        if known is not None:
            room = known._replace(floor=room.floor or known.floor, doors=(*known.doors, *room.doors))  # noqa: PLW2901
        found[fold(room.name)] = room
    if len(found) > MAX_ROOMS:
        raise ConfigError(source, _ROOMS, f"has {len(found):,} rooms; {MAX_ROOMS:,} is the limit")
    doors: dict[str, dict[str, str]] = {key: {} for key in found}
    for key, room in found.items():
        for name in room.doors:
            other = fold(name)
            doors[key].setdefault(other, found[other].name if other in found else name)
            if other in doors:
                doors[other].setdefault(key, room.name)
    return {key: room._replace(doors=tuple(doors[key].values())) for key, room in found.items()}
