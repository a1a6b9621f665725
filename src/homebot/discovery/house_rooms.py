"""The rooms of the house: those of the configuration, and those that were imported, which can be changed. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from homebot.errors import ConfigError, RefusedError
from homebot.places import OUTSIDE, HousePlan, HouseRoom
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["HouseRooms"]


@final
class HouseRooms:
    """The rooms of the house.

    Args:
        home: The name of the home.
        configured: The rooms of the configuration.

    Attributes:
        plan: All rooms.
        imported: Those that were imported.
    """

    __slots__ = ("_configured", "imported", "plan")

    def __init__(self, home: str, configured: Iterable[HouseRoom]) -> None:
        self.plan = self._configured = HousePlan(home, configured)
        self.imported: tuple[HouseRoom, ...] = ()

    def add(self, rooms: Iterable[HouseRoom], source: str) -> None:
        """Import *rooms*.

        Raises:
            ConfigError: They do not fit the plan; nothing was added.
        """
        added = tuple(rooms)
        self.plan = self.plan.with_rooms(added, source)
        self.imported = HousePlan(self.plan.home, (*self.imported, *added), source).rooms

    def restore(self, rooms: tuple[HouseRoom, ...], source: str) -> None:
        """Take over the *imported* rooms of an earlier run.

        Raises:
            ConfigError: Some do not fit the configuration any more; they are remembered, and not in the plan.
        """
        self.imported = rooms
        problem: ConfigError | None = None
        try:
            self.plan = self.plan.with_rooms(rooms, source)
        except ConfigError:
            for room in rooms:
                try:
                    self.plan = self.plan.with_rooms((room,), source)
                except ConfigError as exc:
                    problem = exc
        if problem is not None:
            raise problem

    def remove(self, name: str) -> None:
        """Take an imported room out of the plan, with its doors.

        Raises:
            RefusedError: No import stated it, or the configuration does.
        """
        self._check_imported(name, f"removing the room {name!r}")
        self._change(one for one in self.imported if fold(one.name) != fold(name))

    def rename(self, name: str, new: str, *, is_stated: bool) -> None:
        """Give an imported room another name.

        Args:
            name: The name.
            new: The new name.
            is_stated: Whether devices were placed in it, so that no import need have stated it.

        Raises:
            RefusedError: There is no such room, the configuration has it, or there is one called *new*.
            ConfigError: *new* is the name of a floor or of the home.
        """
        order = f"renaming the room {name!r}"
        if not is_stated or self._configured.room(name) is not None:
            self._check_imported(name, order)
        if fold(new) != fold(name) and self.plan.room(new) is not None:
            raise RefusedError(order, f"there is a room {new!r} already")
        self._change(_renamed(one, name, new) for one in self.imported)

    def _check_imported(self, name: str, order: str) -> None:
        """Refuse *order* where the room *name* is not one that an import alone stated."""
        if self._configured.room(name) is not None:
            raise RefusedError(order, "it is stated in the configuration; change [places] there")
        if all(fold(one.name) != fold(name) for one in self.imported):
            known = [one.name for one in self.imported]
            raise RefusedError(order, f"no import stated it; {did_you_mean(name, known, 'see `homebot places list`')}")

    def _change(self, rooms: Iterable[HouseRoom]) -> None:
        """Make *rooms* the imported ones; a door to a room that is gone goes with it."""
        changed = tuple(rooms)
        known = {fold(one.name) for one in (*changed, *self._configured.rooms)} | {OUTSIDE}
        changed = tuple(one._replace(doors=tuple(to for to in one.doors if fold(to) in known)) for one in changed)
        self.plan = self._configured.with_rooms(changed, "the imported rooms")
        self.imported = changed


def _renamed(room: HouseRoom, name: str, new: str) -> HouseRoom:
    doors = tuple(new if fold(door) == fold(name) else door for door in room.doors)
    return room._replace(name=new if fold(room.name) == fold(name) else room.name, doors=doors)
