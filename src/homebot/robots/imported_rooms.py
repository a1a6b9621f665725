"""The rooms that a robot vacuum adds to the house, renewed as its map changes."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from homebot.devices.names import CHANGE_ROOM, IMPORT_PLACES
from homebot.devices.places_messages import ChangeRoom, ChangeRoomRequest, ImportPlaces, ImportPlacesRequest
from homebot.errors import ConfigError, ServiceError
from homebot.graph import Node
from homebot.places import HousePlan, HouseRoom, places_text

__all__ = ["ImportedRooms"]

NO_ROOMS = "robots.no_rooms"

_SAME = 0.1
"""Metres by which the corners of one area may differ."""


class ImportedRooms:
    """The rooms of one map in the house. A room with an area that is not of that map keeps its area.

    Args:
        node: The node that asks the directory.
        house: Returns the plan of the house as it is now.
    """

    def __init__(self, node: Node, house: Callable[[], HousePlan]) -> None:
        self._node, self._house = node, house
        self._import = node.create_client(ImportPlaces, IMPORT_PLACES)
        self._change = node.create_client(ChangeRoom, CHANGE_ROOM)
        self._before: dict[str, HouseRoom] = {}

    async def renew(self, rooms: Iterable[HouseRoom]) -> None:
        """Import *rooms* in place of those of the map before."""
        plan, wanted, before = self._house(), {one.name: one for one in rooms}, self._before
        if wanted == before:
            return
        self._before = wanted
        try:
            for name in before.keys() - wanted.keys():
                if _is_same(before[name], plan.room(name)):
                    self._report((await self._change.call(ChangeRoomRequest(room=name))).message)
            new = [one for one in wanted.values() if _may_replace(plan.room(one.name), before.get(one.name), one)]
            if new:
                text = places_text(HousePlan(plan.home, new))
                self._report((await self._import.call(ImportPlacesRequest(text=text))).message)
        except (ConfigError, ServiceError) as exc:
            self._report(str(exc))

    def _report(self, problem: str) -> None:
        if problem:
            self._node.log.warning(NO_ROOMS, message=f"the rooms of a map are not those of the house: {problem}")


def _may_replace(known: HouseRoom | None, before: HouseRoom | None, new: HouseRoom) -> bool:
    """Return whether the area of *known*, a room of the house, is none or that of the map *before*, and not *new*."""
    if known is None or not known.polygons:
        return True
    return before is not None and _is_same(before, known) and not _is_same(new, known)


def _is_same(first: HouseRoom, second: HouseRoom | None) -> bool:
    """Return whether two rooms have the same area."""
    corners, others = (
        [corner for rings in room.polygons for ring in rings for corner in ring] if room is not None else []
        for room in (first, second)
    )
    return len(corners) == len(others) and all(math.dist(*pair) < _SAME for pair in zip(corners, others, strict=True))
