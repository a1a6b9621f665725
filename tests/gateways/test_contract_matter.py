"""The Matter gateway keeps the contract, on the WebSocket of a simulated Matter server."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from anyio.abc import TaskGroup, TaskStatus
from tests.gateways.contract import GatewayContract, Lamp

from homebot.gateways import Gateway
from homebot.gateways.matter import MatterGateway, MatterGatewaySettings
from homebot.graph import Node
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.matter import ServedMatterNode, SimulatedMatterServer


class MatterLamp(Lamp):
    """A lamp that is commissioned when it comes into the house."""

    def __init__(self, server: SimulatedMatterServer, tasks: TaskGroup) -> None:
        super().__init__("node-1", "1", address="matter/node-1")
        self.server = server
        self.tasks = tasks
        self.orders: list[str] = []
        device = SimulatedDeviceInfo("home", "lamp", "Hall", "lights", "hall")
        self.node = ServedMatterNode(device, self.orders.append, server)
        self.node.begin(DeviceState(text="off"), has_power=True)
        self._serving: anyio.CancelScope | None = None

    async def announce(self) -> None:
        await self.tasks.start(self.node.serve)

    async def report(self, *, on: bool) -> None:
        self.node.change("1/6/0", on)

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"event": "attribute_updated", "data": [1, "1/6/0", on]}, separators=(",", ":")).encode()

    async def misbehave(self) -> None:
        for number in range(2000):
            self.server.tell("attribute_updated", [1000 + number, "1/6", "?" * 10_000])
            if number % 50 == 0:
                await anyio.sleep(0.01)

    async def withdraw(self) -> None:
        self.server.remove(self.node)

    async def told(self) -> bool | None:
        return self.orders[-1] == "on" if self.orders else None

    async def _serve(self, *, task_status: TaskStatus[None]) -> None:
        with anyio.CancelScope() as self._serving:
            await self.server.serve(task_status=task_status)

    async def lose_link(self) -> None:
        assert self._serving is not None
        self._serving.cancel()
        await anyio.sleep(0.01)

    async def mend_link(self) -> None:
        await self.tasks.start(self._serve)


class TestMatterGateway(GatewayContract):
    """One lamp."""

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with anyio.create_task_group() as tasks:
            lamp = MatterLamp(SimulatedMatterServer(), tasks)
            await lamp.mend_link()
            yield lamp
            tasks.cancel_scope.cancel()

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, MatterLamp)
        return MatterGateway(node, MatterGatewaySettings.model_validate({"url": lamp.server.url, **settings}))
