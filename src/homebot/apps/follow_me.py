"""Follow me: turns on the lamps of a dark room when a person comes in."""

from typing import Annotated

from pydantic import Field

from homebot.apps.base import App, AppSettings
from homebot.apps.rooms import in_room, per_room
from homebot.devices.handles import HandleChange, Light, LightSensor, OccupancySensor
from homebot.devices.health import GetHealth
from homebot.devices.misspelt_names import ConfiguredNames, StatedNames
from homebot.support.folding import fold


class FollowMeSettings(AppSettings):
    """The keys of the table of :class:`FollowMe`.

    Attributes:
        dark_below: Lux below which a room is dark, according to the darkest of its light sensors.
        without_light_sensor: Whether a room without a current light sensor counts as dark.
        rooms: The rooms in which lamps are turned on, empty for all; leave out bedrooms.
    """

    dark_below: Annotated[float, Field(gt=0, allow_inf_nan=False)] = 50.0
    without_light_sensor: bool = True
    rooms: tuple[str, ...] = ()


class FollowMe(App[FollowMeSettings]):
    """Turns on the lamps of a dark room when a motion sensor there begins to detect motion; turns nothing off.

    A room in which a lamp is already on is left as it is.
    """

    async def run(self) -> None:
        """Light up a room with each motion in it."""
        names = ConfiguredNames(self.node, lambda: StatedNames([("rooms", room) for room in self.settings.rooms]))
        self.node.create_service(GetHealth, "~/health", names.health)
        self.start_task(names.run)
        motion = self.devices.follow(OccupancySensor, fresh=True).became(occupied=True)
        self.on(motion, self._light_up, mode="restart", key=per_room)

    async def _light_up(self, change: HandleChange[OccupancySensor]) -> None:
        room, rooms = change.handle.area, set(map(fold, self.settings.rooms))
        if not rooms or fold(room) in rooms:
            lamps = in_room(await self.devices.find(Light), room)
            if not any(lamp.on for lamp in lamps) and await self._is_dark(room):
                await self.each(Light.turn_on, lamps)

    async def _is_dark(self, room: str) -> bool:
        sensors = in_room(await self.devices.find(LightSensor, fresh=True, optional=True), room)
        lux = [sensor.lux for sensor in sensors if sensor.lux is not None and sensor.reachable is not False]
        return min(lux) < self.settings.dark_below if lux else self.settings.without_light_sensor
