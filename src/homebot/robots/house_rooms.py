"""The rooms of the house as the directory has them, and those that a robot vacuum adds to them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import anyio
from anyio import to_thread

from homebot.devices.names import CHANGE_ROOM, DIRECTORY_NODE, EXPORT_PLACES, IMPORT_PLACES, OWNER_REQUESTS
from homebot.devices.places_messages import (
    ExportPlaces,
    ExportPlacesRequest,
    ImportPlaces,
    ImportPlacesRequest,
    OwnerRequest,
)
from homebot.errors import ConfigError, ServiceError
from homebot.graph import Node
from homebot.places import HousePlan, HouseRoom, places_text, read_places
from homebot.support.toml_file import parse_toml

__all__ = ["HouseRoomsReader"]

NO_ROOMS = "robots.no_rooms"

_SOURCE = "the places file"
_CARRIED_OUT = 0.2
"""Seconds from the announcement of a change of rooms to the end of that change."""


class HouseRoomsReader:
    """Reads the rooms of the house at the start and after each change.

    Args:
        node: The node that reads.
        set_plan: Takes the plan.
    """

    def __init__(self, node: Node, home: str, set_plan: Callable[[HousePlan], None]) -> None:
        self._node = node
        self._home = home
        self._set_plan = set_plan
        self._export = node.create_client(ExportPlaces, EXPORT_PLACES)
        self._import = node.create_client(ImportPlaces, IMPORT_PLACES)
        self._requests = node.create_subscription(OwnerRequest, OWNER_REQUESTS, None, 10, from_node=DIRECTORY_NODE)

    async def run(self) -> None:
        """Read until cancelled."""
        await self._read()
        async for request in self._requests:
            if request.service in {IMPORT_PLACES, CHANGE_ROOM}:
                await anyio.sleep(_CARRIED_OUT)
                await self._read()

    async def add(self, rooms: Iterable[HouseRoom], known: HousePlan) -> None:
        """Import those of *rooms* that have no area in the plan *known*."""
        new = [one for one in rooms if (room := known.room(one.name)) is None or not room.polygons]
        if not new:
            return
        try:
            text = places_text(HousePlan(self._home, new))
            answer = await self._import.call(ImportPlacesRequest(text=text))
            problem = "" if answer.success else answer.message
        except (ConfigError, ServiceError) as exc:
            problem = str(exc)
        if problem:
            self._node.log.warning(NO_ROOMS, message=f"the rooms of a map are not added to the house: {problem}")

    async def _read(self) -> None:
        try:
            text = (await self._export.call(ExportPlacesRequest())).text
            self._set_plan(await to_thread.run_sync(self._plan_of, text))
        except (ConfigError, ServiceError) as exc:
            self._node.log.warning(NO_ROOMS, message=f"the rooms of the house are not known to robots: {exc}")

    def _plan_of(self, text: str) -> HousePlan:
        table = parse_toml(text, _SOURCE).get("places", {})
        places = read_places(table if isinstance(table, dict) else {}, self._home, _SOURCE, "import")
        return HousePlan(self._home, places.rooms, _SOURCE, places.doors)
