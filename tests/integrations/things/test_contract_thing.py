"""The mDNS gateway keeps the contract with the driver for things: a simulated thing that zeroconf announces."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import ClassVar

import anyio
from tests.gateways.lamp_orders import INFO, OrderedLamp
from tests.gateways.mdns.lamp import LOOPBACK, SERVICE_TYPE, Publisher, publisher
from tests.gateways.test_contract_mdns import Cable, MdnsLamp
from tests.things.thing import ServedThing

from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings, NetworkInterfaces
from homebot.graph import Node
from homebot.house.dialect import DeviceState
from homebot.integrations.things.driver import ThingDriver
from homebot.testing.gateway_contract import GatewayContract, Lamp


class AnnouncedThingDriver(ThingDriver):
    """The driver, for the service type of this process alone."""

    service_types: ClassVar[frozenset[str]] = frozenset({SERVICE_TYPE})


class ThingLamp(OrderedLamp):
    """A thing on loopback."""

    device: ServedThing

    def __init__(self, computer: Publisher) -> None:
        key = f"Hall.{SERVICE_TYPE}"
        super().__init__(key, address=key)
        self.computer = computer
        self.cable = Cable()
        self.device = ServedThing(INFO, self.obey)
        self.device.begin(DeviceState(text="off"), has_power=True)

    async def announce(self) -> None:
        await self.computer.announce("Hall", self.device.server.port, {"td": "/.well-known/wot", "type": "Thing"})

    async def misbehave(self) -> None:
        await MdnsLamp.misbehave(self)  # type: ignore[arg-type]  # what a stranger sends is the same

    async def withdraw(self) -> None:
        await self.computer.withdraw("Hall")

    async def lose_link(self) -> None:
        self.cable.move(is_in=False)

    async def mend_link(self) -> None:
        self.cable.move(is_in=True)


class TestThings(GatewayContract):
    """One lamp."""

    name = "mdns"

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with publisher() as computer, anyio.create_task_group() as tasks:
            lamp = ThingLamp(computer)
            await tasks.start(lamp.device.serve)
            yield lamp
            tasks.cancel_scope.cancel()

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, ThingLamp)
        table = {
            "interfaces": [LOOPBACK],
            "service_types": [SERVICE_TYPE],
            "announce": False,
            "drivers": {f"{__name__}:AnnouncedThingDriver": {}},
            **settings,
        }
        context = GatewayContext(services={NetworkInterfaces: lamp.cable})
        return MdnsGateway(node, MdnsGatewaySettings.model_validate(table), context)
