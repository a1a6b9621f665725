"""The gateway in memory keeps the contract; in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import pytest
from tests.gateways.contract import GatewayContract, Lamp, running

from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node


class MemoryLamp(Lamp):
    """A lamp of the gateway in memory."""

    gateway: MemoryGateway

    async def announce(self) -> None:
        self.gateway.devices.put(GatewayDevice(self.key, "Hall", (simple_part("light", settable=("on_off",)),)), "new")
        await self.report(on=False)

    async def report(self, *, on: bool) -> None:
        await self.gateway.devices.report(self.key, {"on_off": on})

    async def withdraw(self) -> None:
        self.gateway.devices.remove(self.key, "it was sold")

    async def told(self) -> bool | None:
        value = self.gateway.commands[-1].value.plain() if self.gateway.commands else None
        return value if isinstance(value, bool) else None

    async def lose_link(self) -> None:
        self.gateway.set_unavailable("the radio is unplugged")

    async def mend_link(self) -> None:
        self.gateway.set_available()


@pytest.mark.virtual_time
class TestMemoryGateway(GatewayContract):
    """One lamp."""

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with Node(Graph(), "memory", namespace="/gateway") as node:
            gateway = MemoryGateway(node)
            async with running(gateway):
                yield MemoryLamp(gateway, "hall")
