"""The rooms of the house: those of the configuration, and imported ones, which can be changed. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

import homebot.places
from homebot.errors import ConfigError, RefusedError
from homebot.places import OUTSIDE, HouseDoor, HousePlan, HouseRoom, Places
from homebot.support.folding import fold
from homebot.support.names import did_you_mean


@final
class HouseRooms:
    """The rooms of the house."""

    def __init__(self, home: str, configured: Iterable[HouseRoom], doors: Iterable[HouseDoor] = ()) -> None:
        self.plan = self._configured = HousePlan(home, configured, doors=doors)
        self.imported: tuple[HouseRoom, ...] = ()
        self.imported_doors: tuple[HouseDoor, ...] = ()

    def add(self, rooms: Iterable[HouseRoom], source: str, doors: Iterable[HouseDoor] = ()) -> None:
        """Import *rooms* and *doors*.

        Raises:
            ConfigError: They contradict the plan; nothing was added.
        """
        added, added_doors = tuple(rooms), tuple(doors)
        self.plan = _check(self.plan.with_rooms(added, source, added_doors))
        self.imported = HousePlan(self.plan.home, (*self.imported, *added), source).rooms
        self.imported_doors = tuple({fold(door.name): door for door in (*self.imported_doors, *added_doors)}.values())

    def restore(self, rooms: tuple[HouseRoom, ...], source: str, doors: tuple[HouseDoor, ...] = ()) -> None:
        """Restore the imported *rooms* and *doors* of an earlier run.

        Raises:
            ConfigError: Some contradict the configuration; they are remembered, but left out of the plan.
        """
        self.imported, self.imported_doors = rooms, doors
        problem: ConfigError | None = None
        try:
            self.plan = _check(self.plan.with_rooms(rooms, source, doors))
        except ConfigError:
            for added, further in [*(((room,), ()) for room in rooms), *(((), (door,)) for door in doors)]:
                try:
                    self.plan = _check(self.plan.with_rooms(added, source, further))
                except ConfigError as exc:
                    problem = exc
        if problem is not None:
            raise problem

    def reconfigured(self, places: Places) -> HouseRooms:
        """Return the rooms of another configuration together with the imported ones.

        Raises:
            ConfigError: They contradict each other.
        """
        rooms = HouseRooms(self.plan.home, places.rooms, places.doors)
        rooms.restore(self.imported, "the imported rooms", self.imported_doors)
        return rooms

    def remove(self, name: str) -> None:
        """Remove an imported room and its doors from the plan.

        Raises:
            RefusedError: It was not imported, or the configuration has it.
        """
        self._check_imported(name, f"removing the room {name!r}")
        self._change((room for room in self.imported if fold(room.name) != fold(name)), self.imported_doors)

    def rename(self, name: str, new: str, *, is_stated: bool) -> None:
        """Rename an imported room.

        Args:
            is_stated: Whether devices were placed in it, so that it need not have been imported.

        Raises:
            RefusedError: There is no such room, the configuration has it, or there is one called *new*.
            ConfigError: *new* is the name of a floor or of the home.
        """
        order = f"renaming the room {name!r}"
        if not is_stated or self._configured.room(name) is not None:
            self._check_imported(name, order)
        if fold(new) != fold(name) and self.plan.room(new) is not None:
            raise RefusedError(order, f"there is a room {new!r} already")
        doors = [
            door._replace(rooms=(_spell(door.rooms[0], name, new), _spell(door.rooms[1], name, new)))
            for door in self.imported_doors
        ]
        self._change((_rename(room, name, new) for room in self.imported), doors)

    def _check_imported(self, name: str, order: str) -> None:
        """Refuse *order* unless the room *name* comes from an import alone."""
        if self._configured.room(name) is not None:
            raise RefusedError(order, "it is stated in the configuration; change [places] there")
        if all(fold(room.name) != fold(name) for room in self.imported):
            known = [room.name for room in self.imported]
            raise RefusedError(order, f"no import stated it; {did_you_mean(name, known, 'see `homebot places list`')}")

    def _change(self, rooms: Iterable[HouseRoom], doors: Iterable[HouseDoor]) -> None:
        """Set the imported *rooms* and *doors*, without doors to rooms that are gone."""
        changed = tuple(rooms)
        known = {fold(room.name) for room in (*changed, *self._configured.rooms)} | {OUTSIDE}
        changed = tuple(room._replace(doors=tuple(to for to in room.doors if fold(to) in known)) for room in changed)
        joined = tuple(door for door in doors if known.issuperset(map(fold, door.rooms)))
        self.plan = _check(self._configured.with_rooms(changed, "the imported rooms", joined))
        self.imported, self.imported_doors = changed, joined


def _check(plan: HousePlan) -> HousePlan:
    """Return *plan*.

    Raises:
        ConfigError: An area is none, or a door is not at its rooms.
    """
    if plan.has_areas:
        homebot.places.FloorPlan.of(plan)
    return plan


def _rename(room: HouseRoom, name: str, new: str) -> HouseRoom:
    doors = tuple(_spell(door, name, new) for door in room.doors)
    return room._replace(name=_spell(room.name, name, new), doors=doors)


def _spell(room: str, name: str, new: str) -> str:
    return new if fold(room) == fold(name) else room
