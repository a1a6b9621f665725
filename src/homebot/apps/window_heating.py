"""Window heating: lowers the thermostats of a room while a window in it is open."""

from functools import partial

from homebot.apps.base import App, AppSettings
from homebot.apps.rooms import in_room, per_room
from homebot.devices.handles import Closure, ContactSensor, HandleChange, Thermostat
from homebot.support.folding import fold
from homebot.units import Celsius, Seconds


class WindowHeatingSettings(AppSettings):
    """The keys of its table: how long a window must be open, and the lowered setpoint in °C."""

    open_for: Seconds = 60.0
    lowered_to: Celsius = 12.0


class WindowHeating(App[WindowHeatingSettings]):
    """Lowers the heating while a window or contact in its room is open; keeps a setpoint that was changed meanwhile.

    A thermostat that is off is left alone, as many turn on by a setpoint; it is lowered, or restored, once it is on.
    The setpoints to restore are kept across restarts.
    """

    async def run(self) -> None:
        """Lower and restore setpoints as windows open and close."""
        self._setpoints: dict[str, float] = self.store.setdefault("setpoints", {})
        follow, lasting = self.devices.follow, self.settings.open_for
        opened = (
            follow(ContactSensor, optional=True).became(is_open=True, lasting=lasting),
            follow(Closure, optional=True).became(closed=False, lasting=lasting),
        )
        closed = (
            follow(ContactSensor, is_open=True, optional=True).only("removed"),
            follow(Closure, closed=False, optional=True).only("removed"),
        )
        self.on(opened, lambda change: self._lower(change.handle.area), key=per_room, mode="queued")
        self.on(closed, lambda change: self._restore(change.handle.area), key=per_room, mode="queued")
        self.on(follow(Thermostat, mode="off").only("removed"), self._on_again, key=per_room, mode="queued")
        self.after(lasting, self._restore_all)  # windows may have been closed before the start

    async def _on_again(self, change: HandleChange[Thermostat]) -> None:
        room = change.handle.area
        await (self._lower(room) if await self._is_open(room) else self._restore(room))

    async def _lower(self, room: str) -> None:
        low, thermostats = self.settings.lowered_to, in_room(await self.devices.find(Thermostat), room)
        new = {
            thermostat: now
            for thermostat in thermostats
            if (now := thermostat.heating_setpoint or 0.0) > low
            and thermostat.id not in self._setpoints
            and not _is_off(thermostat)
        }
        self._setpoints |= {thermostat.id: now for thermostat, now in new.items()}
        await self.each(lambda thermostat: thermostat.heat_to(low), new)

    async def _restore_all(self) -> None:
        for room in {
            fold(thermostat.area)
            for thermostat in await self.devices.find(Thermostat)
            if thermostat.id in self._setpoints
        }:
            await self._restore(room)

    async def _is_open(self, room: str) -> bool:
        windows = (
            *await self.devices.find(ContactSensor, is_open=True, optional=True),
            *await self.devices.find(Closure, closed=False, optional=True),
        )
        return bool(in_room(windows, room))

    async def _restore(self, room: str) -> None:
        if not await self._is_open(room):
            for thermostat in in_room(await self.devices.find(Thermostat), room):
                if (before := self._setpoints.get(thermostat.id)) is not None and not _is_off(thermostat):
                    self.start_task(partial(self._restore_one, thermostat, before))

    async def _restore_one(self, thermostat: Thermostat, before: float) -> None:
        is_changed = thermostat.heating_setpoint not in {None, self.settings.lowered_to, before}
        if is_changed or (await self.each(lambda one: one.heat_to(before), [thermostat]))[0].succeeded:
            self._setpoints.pop(thermostat.id, None)


def _is_off(thermostat: Thermostat) -> bool:
    return thermostat.mode == "off" or thermostat.value("on_off") is False
