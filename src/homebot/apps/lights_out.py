"""Lights out: the lamps of a room go off when its motion sensors have been quiet for a while."""

from __future__ import annotations

import anyio

from homebot.apps.base import AppSettings
from homebot.apps.room_app import RoomApp, in_room
from homebot.devices.handles import HandleChange, Light, OccupancySensor
from homebot.graph import Node
from homebot.units import Seconds

__all__ = ["LightsOut", "LightsOutSettings"]
SHORTEST, LONGEST = 60.0, 3600.0  # seconds until lamps that stayed on are looked at again, longer each time


class LightsOutSettings(AppSettings):
    """The keys of the table of :class:`LightsOut`.

    Attributes:
        quiet_after: Seconds for which all motion sensors of a room must be quiet, and no lamp be turned on there.
    """

    quiet_after: Seconds = 1260.0  # a minute more than the presence guard waits


class LightsOut(RoomApp[LightsOutSettings]):
    """Turns off the lamps of a room after all its motion sensors, at least one, have detected no motion for a while."""

    def __init__(self, node: Node, settings: LightsOutSettings) -> None:
        super().__init__(node, settings)
        self._quiet_after = settings.quiet_after
        self._quiet: dict[OccupancySensor, str] = {}  # none that is stale, unreachable or silent; and the room of each
        self.watch(self.devices.follow(OccupancySensor, occupied=False, fresh=True), self._on_sensor)
        self.watch(self.devices.follow(Light, on=True), self._on_lamp)

    def _on_sensor(self, change: HandleChange[OccupancySensor]) -> None:
        sensor, room = change.handle, self._quiet.pop(change.handle, None)
        if change.kind != "removed" and sensor.reachable is not False:
            self._quiet[sensor] = sensor.area
        if room != self._quiet.get(sensor):
            self.start(sensor.area, self._count_down)

    def _on_lamp(self, change: HandleChange[Light]) -> None:
        if change.kind == "appeared":
            self.start(change.handle.area, self._count_down)

    async def _count_down(self, room: str) -> None:
        await anyio.sleep(self._quiet_after)
        wait = max(self._quiet_after, SHORTEST)
        while lamps := in_room(await self.devices.find(Light, on=True), room):
            sensors = in_room(await self.devices.find(OccupancySensor), room)
            is_quiet = bool(sensors) and self._quiet.keys() >= set(sensors)
            if is_quiet and all(await self.each(lambda lamp: self.attempt(lamp, lamp.turn_off), lamps)):
                return
            wait = min(2 * wait, max(wait, LONGEST))  # each try is an entry in the journal
            await anyio.sleep(wait)
