"""The gateway in memory keeps the contract; in virtual time."""

import json
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import ClassVar

import pytest

from homebot.devices.gateway_messages import Command, Report
from homebot.devices.value import PlainValue, Value
from homebot.gateways import Gateway
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.memory import MemoryGateway, MemoryGatewaySettings
from homebot.graph import Node
from homebot.testing.gateway_contract import GatewayContract, Lamp, Neighbour
from homebot.testing.gateway_contract.steps import kept, listen, value

UNPLUGGED = "the radio is unplugged"


class MemoryLamp(Lamp):
    """A lamp of the gateway in memory."""

    gateway: MemoryGateway
    is_linked = True
    settings: ClassVar[Mapping[str, PlainValue]] = {
        "level": 40.0,
        "color": (120.0, 80.0),
        "color_temperature": 2700.0,
        "effect": "fire",
    }

    async def announce(self) -> None:
        self._reports = listen(self.gateway.node, Report, self.gateway.names.readings)
        self._is_on = False
        part = simple_part("light", settable=("on_off", *self.settings))
        self.gateway.devices.put(GatewayDevice(self.key, self.name, (part,), raw_address=self.address), "new")
        await self.report(on=False)

    async def report(self, *, on: bool) -> None:
        await self.gateway.receive(self.key, self.raw(on=on))

    def raw(self, *, on: bool) -> bytes:
        return json.dumps({"on_off": on}).encode()

    async def misbehave(self) -> None:
        for number in range(2000):
            await self.gateway.receive(f"stranger {number}", b"?")

    async def meet_again(self) -> None:
        """Memory ends with the gateway, so that a device says again that it is there."""
        await self.announce()

    async def withdraw(self) -> None:
        self.gateway.devices.remove(self.key, "it was sold")

    async def told(self) -> bool | None:
        """What it is after that: it does what it is told, and reports it."""
        for report in kept(self._reports):
            if (is_on := value(self, report)) is not None:
                self._is_on = is_on is True
        return self._is_on if self.gateway.commands else None

    async def told_value(self, capability: str) -> PlainValue:
        told = [one.value.plain() for one in self.gateway.commands if one.capability == capability]
        return told[-1] if told else None

    async def lose_link(self) -> None:
        self.is_linked = False
        if hasattr(self, "gateway"):
            self.gateway.set_unavailable(UNPLUGGED)

    async def mend_link(self) -> None:
        self.is_linked = True
        self.gateway.set_available()


class Onlooker(Neighbour):
    """Another system that sees what the gateway in memory shows."""

    def __init__(self, gateway: MemoryGateway) -> None:
        self._gateway = gateway

    async def seen(self, name: str) -> bool | None:
        for offer, states in self._gateway.exposed.values():
            if offer.name == name:
                value = states.get(("", "on_off"))
                return value if isinstance(value, bool) else None
        return None

    async def turn(self, name: str, *, on: bool) -> None:
        (key,) = (offer.id for offer, _ in self._gateway.exposed.values() if offer.name == name)
        self._gateway.command_exposed(Command(key=key, part="", capability="on_off", value=Value.of(on)))


@pytest.mark.virtual_time
class TestMemoryGateway(GatewayContract):
    """One lamp."""

    time_is_virtual = True

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        yield MemoryLamp("hall", address="memory/hall")

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, MemoryLamp)
        gateway = MemoryGateway(node, MemoryGatewaySettings.model_validate(settings))
        if not lamp.is_linked:
            gateway.set_unavailable(UNPLUGGED)
        return gateway

    def neighbour(self, lamp: Lamp) -> Neighbour:
        assert isinstance(lamp, MemoryLamp)
        return Onlooker(lamp.gateway)
