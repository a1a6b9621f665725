"""Follow me: the lamps of a dark room go on when a person comes in."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from homebot.apps.base import AppSettings
from homebot.apps.room_app import RoomApp, in_room
from homebot.devices.handles import HandleChange, Light, LightSensor, OccupancySensor
from homebot.graph import Node
from homebot.support.folding import fold

__all__ = ["FollowMe", "FollowMeSettings"]


class FollowMeSettings(AppSettings):
    """The keys of the table of :class:`FollowMe`.

    Attributes:
        dark_below: Lux below which a room is dark, by the darkest of its light sensors.
        without_light_sensor: Whether a room without a current light sensor counts as dark.
        rooms: The rooms in which lamps are turned on, empty for all; leave out bedrooms.
    """

    dark_below: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 50.0
    without_light_sensor: bool = True
    rooms: tuple[str, ...] = ()


class FollowMe(RoomApp[FollowMeSettings]):
    """Turns on the lamps of a dark room when a motion sensor there begins to detect motion; turns nothing off.

    A room in which a lamp is on already is left as it is.
    """

    def __init__(self, node: Node, settings: FollowMeSettings) -> None:
        super().__init__(node, settings, settings.rooms)
        self._rooms = {fold(room) for room in settings.rooms}
        self.watch(self.devices.follow(OccupancySensor, occupied=True, fresh=True), self._on_motion)

    def _on_motion(self, change: HandleChange[OccupancySensor]) -> None:
        if change.kind == "appeared" and (not self._rooms or fold(change.handle.area) in self._rooms):
            self.start(change.handle.area, self._light_up)

    async def _light_up(self, room: str) -> None:
        lamps = in_room(await self.devices.find(Light), room)
        if not any(lamp.on for lamp in lamps) and await self._is_dark(room):
            await self.each(lambda lamp: self.attempt(lamp, lamp.turn_on), lamps)

    async def _is_dark(self, room: str) -> bool:
        sensors = in_room(await self.devices.find(LightSensor, fresh=True), room)
        lux = [one.lux for one in sensors if one.lux is not None and one.reachable is not False]
        return min(lux) < self.settings.dark_below if lux else self.settings.without_light_sensor
