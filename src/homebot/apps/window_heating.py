"""Window and heating: the thermostats of a room are set lower while a window in it is open."""

from __future__ import annotations

import anyio

from homebot.apps.base import AppSettings
from homebot.apps.room_app import RoomApp, in_room
from homebot.devices.handles import Closure, ContactSensor, HandleChange, Thermostat
from homebot.graph import Node
from homebot.units import Celsius, Seconds

__all__ = ["WindowHeating", "WindowHeatingSettings"]


class WindowHeatingSettings(AppSettings):
    """The keys of its table: the time for which a window must be open, and the setpoint in °C from then on."""

    open_for: Seconds = 60.0
    lowered_to: Celsius = 12.0


class WindowHeating(RoomApp[WindowHeatingSettings]):
    """Lowers the heating while a window or contact of its room is open; leaves a setpoint that was changed meanwhile.

    The setpoints to restore are kept in memory only: a heater that is lowered at the end of a run stays lowered.
    """

    def __init__(self, node: Node, settings: WindowHeatingSettings) -> None:
        super().__init__(node, settings)
        self._open_for, self._low = settings.open_for, settings.lowered_to
        self._open: set[ContactSensor | Closure] = set()
        self._setpoints: dict[Thermostat, float] = {}
        self.watch(self.devices.follow(ContactSensor, is_open=True), self._on_window)
        self.watch(self.devices.follow(Closure, closed=False), self._on_window)

    def _on_window(self, change: HandleChange[ContactSensor] | HandleChange[Closure]) -> None:
        room, is_closed = change.handle.area, change.kind == "removed"
        was_open = bool(in_room(self._open, room))
        (self._open.discard if is_closed else self._open.add)(change.handle)
        if was_open != bool(in_room(self._open, room)):
            self.start(room, self._restore if is_closed else self._lower)

    async def _lower(self, room: str) -> None:
        await anyio.sleep(self._open_for)
        found = in_room(await self.devices.find(Thermostat), room)
        setpoints = {one: now for one in found if (now := one.heating_setpoint or 0.0) > self._low}
        self._setpoints = setpoints | self._setpoints
        await self.each(lambda one: self.attempt(one, lambda: one.heat_to(self._low)), setpoints)

    async def _restore(self, room: str) -> None:
        await self.each(self._restore_one, in_room(self._setpoints, room))

    async def _restore_one(self, one: Thermostat) -> None:
        is_changed = one.heating_setpoint not in {None, self._low, self._setpoints[one]}
        if is_changed or await self.attempt(one, lambda: one.heat_to(self._setpoints[one])):
            del self._setpoints[one]
