"""The light service: it turns off every lamp that reports that it is on."""

from __future__ import annotations

from functools import partial

from pydantic import BaseModel

from homebot.apps.room_app import RoomApp
from homebot.devices import Device, RawMessage
from homebot.devices.current_trigger import current_trigger
from homebot.devices.handles import HandleChange, Light
from homebot.graph import Node
from homebot.messages import Time

__all__ = ["LightService"]
LOOKS_AGAIN = 300.0  # seconds until lamps that did not obey, or that a policy kept on, are turned off again


class LightService(RoomApp):
    """Turns off each lamp that reports that it is on, those that appear later too; a dimmed lamp is on."""

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        self._answered: dict[Light, Time] = {}  # the newest report of each, which comes as a change and as a text
        self._turning_off: set[Light] = set()
        self.watch(self.devices.follow(Light), self._on_light)
        node.create_timer(LOOKS_AGAIN, self._look_again)

    def _on_light(self, change: HandleChange[Light]) -> None:
        if change.kind == "appeared":
            self.listen(change.handle.device, partial(self._on_message, change.handle.device))
        if change.handle.on is False and change.kind != "removed" and change.handle not in self._turning_off:
            self.log_limited("light_service.is_off", change.handle, "is off")
        self._start(change.handle)

    def _on_message(self, device: Device, message: RawMessage) -> None:
        if message.payload.strip().lower() == b"on":  # of a lamp that was on already, no change
            for lamp in self.devices.handles(device, Light):
                self._start(lamp)

    async def _look_again(self) -> None:
        self._answered.clear()
        for lamp in await self.devices.find(Light):
            self._start(lamp)

    def _start(self, lamp: Light) -> None:
        if lamp.on and not lamp.is_gone and self._answered.get(lamp) != current_trigger().at:
            self._answered[lamp] = current_trigger().at
            self.start_task(partial(self._turn_off, lamp))

    async def _turn_off(self, lamp: Light) -> None:
        self._turning_off.add(lamp)
        if await self.attempt(lamp, lamp.turn_off):
            self.log_limited("light_service.turned_off", lamp, "is on: turned it off")
        self._turning_off.discard(lamp)
