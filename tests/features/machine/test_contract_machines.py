"""A gateway of another machine keeps the contract, with the gateway in memory on the other side, over Zenoh."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import ClassVar

import pytest
from tests.features.machine.far_machine import FarMachine, far_machine
from tests.gateways.test_contract_memory import MemoryLamp

from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.graph import Node
from homebot.testing.gateway_contract import GatewayContract, Lamp

pytestmark = pytest.mark.slow


class FarLamp(Lamp):
    """A lamp of another machine, whose link is the one that is lost."""

    settings: ClassVar[Mapping[str, PlainValue]] = MemoryLamp.settings

    def __init__(self, there: MemoryLamp, machine: FarMachine) -> None:
        super().__init__(there.key, address=there.address)
        self._there, self.machine = there, machine

    async def announce(self) -> None:
        await self._there.announce()

    async def report(self, *, on: bool) -> None:
        await self._there.report(on=on)

    def raw(self, *, on: bool) -> bytes:
        return self._there.raw(on=on)

    async def misbehave(self) -> None:
        await self._there.misbehave()

    async def withdraw(self) -> None:
        await self._there.withdraw()

    async def told(self) -> bool | None:
        return await self._there.told()

    async def told_value(self, capability: str) -> PlainValue:
        return await self._there.told_value(capability)

    async def lose_link(self) -> None:
        await self.machine.lose_link()

    async def mend_link(self) -> None:
        await self.machine.mend_link()


class TestMachineGateway(GatewayContract):
    """One lamp."""

    @pytest.fixture(autouse=True)
    def _folder(self, tmp_path: Path) -> None:
        self._secrets = tmp_path

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        there = MemoryLamp("hall", address="memory/hall")
        async with far_machine() as machine:
            there.gateway = machine.gateway
            yield FarLamp(there, machine)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, FarLamp)
        return lamp.machine.near(node, self._secrets, settings)
