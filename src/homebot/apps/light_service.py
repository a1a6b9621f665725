"""The light service: it turns off every lamp that reports that it is on."""

from __future__ import annotations

from functools import partial

from pydantic import BaseModel

from homebot.apps.room_app import RoomApp
from homebot.devices.handles import HandleChange, Light
from homebot.graph import Node
from homebot.log import LogLimit

__all__ = ["LightService"]

LOOKS_AGAIN = 300.0
"""Seconds after which lamps that are still on, as they did not obey or a policy said no, are turned off again."""


class LightService(RoomApp):
    """Turns off each lamp that reports that it is on, those that appear later too; a dimmed lamp is on."""

    def __init__(self, node: Node, settings: BaseModel) -> None:
        super().__init__(node, settings)
        self._commanded: set[Light] = set()
        self._noted_off: set[Light] = set()
        self._lines = LogLimit(node.graph.clock)
        self.watch(self.devices.follow(Light), self._take)
        node.create_timer(LOOKS_AGAIN, self._look_again)

    def _take(self, change: HandleChange[Light]) -> None:
        lamp = change.handle
        if change.kind == "removed" or lamp.on:
            self._noted_off.discard(lamp)
        elif lamp.on is False and lamp not in self._noted_off:
            self._noted_off.add(lamp)
            self._log("is_off", lamp, "is off")
        self._start(lamp)

    async def _look_again(self) -> None:
        for lamp in await self.devices.find(Light):
            self._start(lamp)

    def _start(self, lamp: Light) -> None:
        if lamp.on and not lamp.is_gone and lamp not in self._commanded:
            self._commanded.add(lamp)
            self.start_task(partial(self._turn_off, lamp))

    async def _turn_off(self, lamp: Light) -> None:
        while lamp.on and await self.attempt(lamp, lamp.turn_off):  # it may be turned on again meanwhile
            self._log("turned_off", lamp, "is on: turned it off")
        self._commanded.discard(lamp)

    def _log(self, event: str, lamp: Light, text: str) -> None:
        if self._lines.allows(f"{event} {lamp.id}") is not None:
            self.node.log.info(f"light_service.{event}", message=f"{lamp.id} {text}", device=lamp.device.id)
