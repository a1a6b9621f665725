"""Lights out: the lamps of a room go off when its motion sensors have been quiet for a while."""

from __future__ import annotations

import anyio

from homebot.apps.base import AppSettings
from homebot.apps.room_app import RoomApp, in_room
from homebot.devices.handles import HandleChange, Light, OccupancySensor
from homebot.graph import Node
from homebot.units import Seconds

__all__ = ["LightsOut", "LightsOutSettings"]


class LightsOutSettings(AppSettings):
    """The keys of the table of :class:`LightsOut`.

    Attributes:
        quiet_after: Seconds for which all motion sensors of a room must be quiet, and no lamp be turned on there.
    """

    quiet_after: Seconds = 600.0


class LightsOut(RoomApp):
    """Turns off the lamps of a room once all its motion sensors have reported no motion for a while.

    Never where that is unknown: in a room without a sensor, or with one that is stale, unreachable or has not reported.
    """

    Settings = LightsOutSettings

    def __init__(self, node: Node, settings: LightsOutSettings) -> None:
        super().__init__(node, settings)
        self._quiet_after = settings.quiet_after
        self._quiet: set[OccupancySensor] = set()
        self.watch(self.devices.follow(OccupancySensor, occupied=False, fresh=True), self._take_quiet)
        self.watch(self.devices.follow(Light, on=True), self._take_lamp)

    def _take_quiet(self, change: HandleChange[OccupancySensor]) -> None:
        if change.kind == "removed" or change.handle.reachable is False:
            self._quiet.discard(change.handle)
            self.cancel(change.handle.area)
        elif change.handle not in self._quiet:
            self._quiet.add(change.handle)
            self.start(change.handle.area, self._count_down)

    def _take_lamp(self, change: HandleChange[Light]) -> None:
        if change.kind == "appeared":
            self.start(change.handle.area, self._count_down)

    async def _count_down(self, room: str) -> None:
        await anyio.sleep(self._quiet_after)
        sensors = in_room(await self.devices.find(OccupancySensor), room)
        if sensors and self._quiet.issuperset(sensors):
            lamps = in_room(await self.devices.find(Light, on=True), room)
            await self.each(lambda lamp: self.attempt(lamp, lamp.turn_off), lamps)
