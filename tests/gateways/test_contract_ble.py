"""The Bluetooth gateway keeps the contract: bleak on a virtual radio, in virtual time."""

from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from random import Random
from typing import ClassVar

import anyio
import pytest
from tests.simulated.virtual_bleak import backend_of
from tests.simulated.virtual_radio import GattValue, VirtualPeripheral, VirtualRadio

from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.gateways.base import GatewayContext
from homebot.gateways.ble import BleGateway, BleGatewaySettings
from homebot.graph import Node
from homebot.testing.gateway_contract import GatewayContract, Lamp

SERVICE = "6e1d0001-0000-4000-8000-0123456789ab"
COMMAND = "6e1d0002-0000-4000-8000-0123456789ab"
STATE = "6e1d0003-0000-4000-8000-0123456789ab"
PROFILE = {
    "service": SERVICE,
    "command": COMMAND,
    "state": STATE,
    "on": "01",
    "off": "00",
    "level": "02{level}",
    "color": "03{red}{green}{blue}",
    "report": "{on}",
}
ADDRESS = "F0:F0:F0:F0:F0:02"
FORGET_AFTER = 20.0
"""Seconds; a lamp that was carried out of the house does not say so."""


class GattLamp(Lamp):
    """A lamp that is connected to, and that its brightness and its colour leave off."""

    settings: ClassVar[Mapping[str, PlainValue]] = {"level": 40.0, "color": (120.0, 100.0)}
    gone_within = 2 * FORGET_AFTER

    def __init__(self, radio: VirtualRadio) -> None:
        super().__init__(ADDRESS, address=f"ble/{ADDRESS}")
        self.radio = radio
        self.is_on = False
        self._told: bool | None = None
        self._values: dict[str, PlainValue] = {}
        self._house = AsyncExitStack()
        self._peripheral: VirtualPeripheral | None = None

    async def announce(self) -> None:
        values = (
            GattValue(COMMAND, write=self._tell),
            GattValue(STATE, read=lambda: self.raw(on=self.is_on), notifies=True),
        )
        self._peripheral = await self._house.enter_async_context(
            self.radio.peripheral(self.name, self.key, {SERVICE: values})
        )
        services = bytes.fromhex(SERVICE.replace("-", ""))[::-1]
        fields = [(0x01, b"\x06"), (0x07, services), (0x09, self.name.encode())]
        await self._peripheral.advertise(fields, 0.5, connectable=True)

    def _tell(self, data: bytes) -> None:
        match data[0]:
            case 2:
                self._values["level"] = data[1] * 100 / 255
            case 3:
                self._values["color"] = (120.0, 100.0) if data[1:] == b"\x00\xff\x00" else None
            case switch:
                self._told = switch == 1

    async def report(self, *, on: bool) -> None:
        self.is_on = on
        assert self._peripheral is not None
        await self._peripheral.notify(STATE, self.raw(on=on))

    def raw(self, *, on: bool) -> bytes:
        return b"\x01" if on else b"\x00"

    async def misbehave(self) -> None:
        for number in range(2000):
            address = ":".join(f"{one:02X}" for one in (0xC0 + number // 256, number % 256, 1, 2, 3, 4))
            self.radio.transmit(address, [(0x01, b"\x06"), (0xFF, b"\x4c\x00\x02\x15")])  # an iBeacon, cut off
            if number % 100 == 0:
                await anyio.sleep(0.01)

    async def withdraw(self) -> None:
        await self._house.aclose()

    async def told(self) -> bool | None:
        return self._told

    async def told_value(self, capability: str) -> PlainValue:
        return self._values.get(capability)

    async def lose_link(self) -> None:
        await self.radio.unplug()

    async def mend_link(self) -> None:
        self.radio.plug_in()


@pytest.mark.virtual_time
class TestBleGateway(GatewayContract):
    """One lamp on a virtual radio."""

    time_is_virtual = True

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with VirtualRadio(Random(1)).running() as radio:  # noqa: S311 - a simulation
            lamp = GattLamp(radio)
            yield lamp
            await lamp.withdraw()

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, GattLamp)
        own = {"signal": False, "forget_after": FORGET_AFTER, "profiles": {"lamp": PROFILE}, **settings}
        backend = backend_of(lamp.radio)
        context = GatewayContext.of(backend, random=Random(2))  # noqa: S311 - a simulation
        return BleGateway(node, BleGatewaySettings.model_validate(own), context)
