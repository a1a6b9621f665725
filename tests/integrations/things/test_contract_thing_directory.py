"""The gateway to a directory of things keeps the contract: a simulated directory, and a thing that it lists."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from tests.gateways.lamp_orders import INFO, OrderedLamp
from tests.gateways.test_contract_coap import Background
from tests.things.directory import ThingDirectoryServer
from tests.things.thing import ServedThing

from homebot.gateways import Gateway
from homebot.graph import Node
from homebot.house.dialect import DeviceState
from homebot.integrations.things.directory import ThingDirectoryGateway, ThingDirectorySettings
from homebot.testing.gateway_contract import GatewayContract, Lamp


class ListedLamp(OrderedLamp):
    """A thing on loopback, and the directory that lists it."""

    device: ServedThing

    def __init__(self, world: Background) -> None:
        self.world = world
        self.directory = ThingDirectoryServer()
        self.device = ServedThing(INFO, self.obey)
        self.device.begin(DeviceState(text="off"), has_power=True)
        key = str(self.device.description()["id"])
        super().__init__(key, address=key)

    async def announce(self) -> None:
        self.directory.register(self.device.description())

    async def misbehave(self) -> None:
        """Let a stranger register what are no descriptions."""
        for number in range(1000):
            self.directory.register({"id": f"urn:stranger:{number}", "@context": [], "title": "?" * 10_000})
            await anyio.sleep(0.001)

    async def withdraw(self) -> None:
        self.directory.delete(self.key)

    async def lose_link(self) -> None:
        await self.world.end()

    async def mend_link(self) -> None:
        await self.world.start(self._serve, self.directory)
        await self.world.start(self._serve, self.device)

    async def _serve(self, one: ServedThing | ThingDirectoryServer, *, task_status: anyio.abc.TaskStatus[None]) -> None:
        await one.serve(task_status=task_status)


class TestThingDirectoryGateway(GatewayContract):
    """One lamp."""

    name = "directory"

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with anyio.create_task_group() as tasks:
            lamp = ListedLamp(Background(tasks))
            await lamp.mend_link()
            yield lamp
            await lamp.world.end()

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, ListedLamp)
        return ThingDirectoryGateway(
            node, ThingDirectorySettings.model_validate({"url": lamp.directory.url, **settings})
        )
