"""The rooms that a robot vacuum adds to the house, renewed as its map changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from homebot.devices.names import CHANGE_ROOM, IMPORT_PLACES
from homebot.devices.places_messages import ChangeRoom, ChangeRoomRequest, ImportPlaces, ImportPlacesRequest
from homebot.errors import ConfigError, ServiceError
from homebot.graph import Node
from homebot.places import HousePlan, HouseRoom, places_text
from homebot.support.folding import fold

__all__ = ["ImportedRooms"]

NO_ROOMS = "robots.no_rooms"

_SAME = 0.1
"""Metres by which the corners of one area may differ."""


class ImportedRooms:
    """The rooms of one map in the house, also those of an earlier run. A room with another area keeps it.

    Args:
        house: Returns the plan of the house as it is now.
    """

    def __init__(self, node: Node, house: Callable[[], HousePlan], robot: str) -> None:
        self._node, self._house, self._robot = node, house, robot
        self._import = node.create_client(ImportPlaces, IMPORT_PLACES)
        self._change = node.create_client(ChangeRoom, CHANGE_ROOM)
        self._before: dict[str, HouseRoom] | None = None

    async def renew(self, rooms: Iterable[HouseRoom]) -> None:
        """Import *rooms* in place of those of the map before."""
        plan, wanted = self._house(), {fold(one.name): one for one in rooms}
        if wanted == self._before:
            return
        self._before = wanted
        try:
            for room in plan.rooms:
                if room.source == self._robot and fold(room.name) not in wanted:
                    self._report((await self._change.call(ChangeRoomRequest(room=room.name))).message)
            if new := [one for one in wanted.values() if self._may_replace(plan.room(one.name), one)]:
                request = ImportPlacesRequest(text=places_text(HousePlan(plan.home, new)), source=self._robot)
                self._report((await self._import.call(request)).message)
        except (ConfigError, ServiceError) as exc:
            self._report(str(exc))

    def _may_replace(self, known: HouseRoom | None, new: HouseRoom) -> bool:
        """Return whether *known*, a room of the house, has no area, or another one of an earlier map."""
        if known is None or not known.polygons:
            return True
        return known.source == self._robot and not _is_same(new, known)

    def _report(self, problem: str) -> None:
        if problem:
            self._node.log.warning(NO_ROOMS, message=f"the rooms of a map are not those of the house: {problem}")


def _is_same(first: HouseRoom, second: HouseRoom) -> bool:
    """Return whether two rooms have the same area."""
    corners, others = (
        [corner for rings in room.polygons for ring in rings for corner in ring] for room in (first, second)
    )
    return len(corners) == len(others) and all(math.dist(*pair) < _SAME for pair in zip(corners, others, strict=True))
