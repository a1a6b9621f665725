"""A gateway with lamps in memory that report their levels as often as they are told to."""

from __future__ import annotations

from itertools import cycle
from typing import ClassVar

import anyio
from anyio.abc import TaskStatus

from homebot.gateways import GatewayContext
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Node

__all__ = ["Lamps"]

TICK = 0.02


class LampsSettings(MemoryGatewaySettings):
    """The table of the gateway: how many lamps it has."""

    devices: int


class Lamps(MemoryGateway):
    """The lamps.

    Attributes:
        running: The gateways of this process.
    """

    Settings = LampsSettings
    running: ClassVar[list[Lamps]] = []

    def __init__(self, node: Node, settings: LampsSettings, context: GatewayContext | None = None) -> None:
        super().__init__(node, settings, context)
        self._count = settings.devices

    async def serve(self, *, task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED) -> None:
        part = simple_part("light", settable=("on_off", "level"))
        name = self.node.name
        for number in range(self._count):
            key = f"{name} lamp {number}"
            self.devices.put(GatewayDevice(key, key, (part,)), "new")
            await self.devices.report(key, {"on_off": False, "level": 10.0})
        self.running.append(self)
        await super().serve(task_status=task_status)

    async def report_for(self, seconds: float, rate: int) -> int:
        """Let the lamps report in turn, *rate* times a second; return how often they did."""
        sent, clock, keys = 0, self.node.graph.clock.monotonic, cycle(self.devices.keys)
        began = clock()
        while (passed := clock() - began) < seconds:
            while sent < passed * rate:
                await self.devices.report(next(keys), {"level": float(sent % 100)})
                sent += 1
            await anyio.sleep(TICK)
        return sent
