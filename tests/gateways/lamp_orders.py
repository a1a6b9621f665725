"""The orders that a simulated lamp was given: ``on``, ``off``, ``0.4`` for a brightness, and ``2700 K``."""

from collections.abc import Mapping, Sequence
from typing import ClassVar

from homebot.devices.value import PlainValue
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.testing.gateway_contract import Lamp

INFO = SimulatedDeviceInfo("house", "lamp", "Hall", "light", "hall")


def is_told_on(orders: Sequence[str]) -> bool | None:
    """Whether the last order that turns it on or off, as a brightness does, turned it on; None without any."""
    switching = [one for one in orders if not one.endswith(" K")]
    return switching[-1] not in {"off", "0"} if switching else None


class OrderedLamp(Lamp):
    """A simulated lamp that says ``true`` or ``false``, and remembers its orders."""

    settings: ClassVar[Mapping[str, PlainValue]] = {"level": 40.0, "color_temperature": 2700.0}
    device: ServedDevice

    def __init__(self, key: str, *, address: str) -> None:
        super().__init__(key, address=address)
        self.orders: list[str] = []

    def obey(self, order: str) -> None:
        self.orders.append(order)

    async def report(self, *, on: bool) -> None:
        self.device.publish(DeviceState(text="on" if on else "off", is_on=on))

    def raw(self, *, on: bool) -> bytes:
        return b"true" if on else b"false"

    async def told(self) -> bool | None:
        return is_told_on(self.orders)

    async def told_value(self, capability: str) -> PlainValue:
        if capability == "color_temperature":
            told = [float(one.removesuffix(" K")) for one in self.orders if one.endswith(" K")]
        else:
            told = [100 * float(one) for one in self.orders if one[0].isdigit() and not one.endswith(" K")]
        return told[-1] if told else None
