"""Window heating: lowers the thermostats of a room while a window in it is open."""

from functools import partial

from homebot.apps.base import App, AppSettings
from homebot.apps.rooms import in_room, per_room
from homebot.devices.handles import Closure, ContactSensor, Handle, HandleChange, Thermostat
from homebot.units import Celsius, Seconds

__all__ = ["WindowHeating", "WindowHeatingSettings"]


class WindowHeatingSettings(AppSettings):
    """The keys of its table: how long a window must be open, and the lowered setpoint in °C."""

    open_for: Seconds = 60.0
    lowered_to: Celsius = 12.0


class WindowHeating(App[WindowHeatingSettings]):
    """Lowers the heating while a window or contact in its room is open; keeps a setpoint that was changed meanwhile.

    The setpoints to restore are in memory only: a heater that is lowered at the end of a run stays lowered.
    """

    async def run(self) -> None:
        """Lower and restore setpoints as windows open and close."""
        self._setpoints: dict[Thermostat, float] = {}
        follow, lasting = self.devices.follow, self.settings.open_for
        opened = (
            follow(ContactSensor).became(is_open=True, lasting=lasting),
            follow(Closure).became(closed=False, lasting=lasting),
        )
        closed = follow(ContactSensor, is_open=True).only("removed"), follow(Closure, closed=False).only("removed")
        self.on(opened, self._lower, key=per_room, mode="queued")
        self.on(closed, self._restore, key=per_room, mode="queued")

    async def _lower(self, change: HandleChange[Handle]) -> None:
        low, found = self.settings.lowered_to, in_room(await self.devices.find(Thermostat), change.handle.area)
        new = {one: now for one in found if (now := one.heating_setpoint or 0.0) > low and one not in self._setpoints}
        self._setpoints |= new
        await self.each(lambda one: one.heat_to(low), new)

    async def _restore(self, change: HandleChange[Handle]) -> None:
        windows = *await self.devices.find(ContactSensor, is_open=True), *await self.devices.find(Closure, closed=False)
        if not in_room(windows, room := change.handle.area):
            for one in in_room(self._setpoints, room):
                self.start_task(partial(self._restore_one, one))

    async def _restore_one(self, one: Thermostat) -> None:
        is_changed = one.heating_setpoint not in {None, self.settings.lowered_to, self._setpoints[one]}
        if is_changed or (await self.each(lambda one: one.heat_to(self._setpoints[one]), [one]))[0].succeeded:
            self._setpoints.pop(one, None)
