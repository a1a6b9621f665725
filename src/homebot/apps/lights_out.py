"""Lights out: turns off the lamps of a room that is quiet, and in which no robot is on its way."""

import anyio

from homebot.apps.base import App, AppSettings
from homebot.apps.rooms import in_room, per_room
from homebot.devices.handles import Handle, HandleChange, Light, OccupancySensor
from homebot.devices.robot_ways import RobotWays
from homebot.graph import Node
from homebot.units import Seconds

MIN_WAIT_S, MAX_WAIT_S = 60.0, 3600.0  # seconds until lamps that stayed on are checked again, longer each time


class LightsOutSettings(AppSettings):
    """The keys of the table of :class:`LightsOut`.

    Attributes:
        quiet_after: Seconds for which all motion sensors of a room must be quiet, and no lamp turned on there.
    """

    quiet_after: Seconds = 1260.0  # a minute more than the presence guard waits


class LightsOut(App[LightsOutSettings]):
    """Turns off the lamps of a room after all its motion sensors, at least one, have detected no motion for a while.

    A robot on its way in a room, or to it, keeps them on.
    """

    def __init__(self, node: Node, settings: LightsOutSettings) -> None:
        super().__init__(node, settings)
        self._ways = RobotWays(node)

    async def run(self) -> None:
        """Restart the countdown of a room with each change in it."""
        changes = (
            self.devices.follow(OccupancySensor, occupied=False, fresh=True).only("appeared", "removed"),
            self.devices.follow(OccupancySensor, reachable=False).only("appeared", "removed"),
            self.devices.follow(Light, on=True).only("appeared"),
        )
        self.on(changes, self._count_down, mode="restart", key=per_room)

    async def _count_down(self, change: HandleChange[Handle]) -> None:
        room, wait = change.handle.area, self.settings.quiet_after
        await anyio.sleep(wait)
        wait = max(wait, MIN_WAIT_S)
        while lamps := in_room(await self.devices.find(Light, on=True), room):
            if await self._is_quiet(room) and all(
                result.succeeded for result in await self.each(Light.turn_off, lamps)
            ):
                return
            wait = min(2 * wait, max(wait, MAX_WAIT_S))  # each attempt is an entry in the journal
            await anyio.sleep(wait)

    async def _is_quiet(self, room: str) -> bool:
        if self._ways.robot_in(room):
            return False
        sensors = in_room(await self.devices.find(OccupancySensor), room)
        quiet = in_room(await self.devices.find(OccupancySensor, occupied=False, fresh=True), room)
        return bool(sensors) and len(quiet) == len(sensors) and all(sensor.reachable is not False for sensor in quiet)
