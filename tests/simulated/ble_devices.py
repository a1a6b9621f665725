"""Simulated Bluetooth devices: any on the virtual radio, and a light that is connected to.

The light's service is of homebot's own making: a characteristic that takes two bytes, whether it is on and how bright
(0 to 255), and one that reports them.
"""

import hashlib
from abc import abstractmethod
from collections.abc import Callable, Mapping

import anyio
from tests.simulated.ble_family import LIGHT_PROFILE
from tests.simulated.virtual_radio import GattValue, VirtualPeripheral, VirtualRadio

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo

EVERY = 1.0
"""Seconds between advertisements."""

LIGHT_SERVICE, LIGHT_COMMAND, LIGHT_STATE = (LIGHT_PROFILE[name] for name in ("service", "command", "state"))
_INFORMATION = "180A"
FLAGS = (0x01, b"\x06")
_SERVICES_128 = 0x07
_NAME = 0x09
_NAME_BYTES = 10
"""Room for a name in 31 bytes."""


def address_of(name: str) -> str:
    """Return the address of the device *name*: random static, the same in every run."""
    digits = bytearray(hashlib.sha256(name.encode()).digest()[:6])
    digits[0] |= 0xC0
    return digits.hex(":").upper()


class RadioDevice(ServedDevice):
    """A device on the virtual radio."""

    def __init__(self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], radio: VirtualRadio) -> None:
        super().__init__(device, on_command)
        self.radio = radio
        self.address = address_of(device.device_id)
        self._changed = anyio.Event()
        self.short_name = _NAME, device.device_id.encode()[:_NAME_BYTES].decode(errors="ignore").encode()

    def show(self) -> None:
        """Have the new state sent."""
        self._changed.set()

    async def serve(self) -> None:
        """Be on the air until cancelled."""
        name = self.device.device_id
        async with self.radio.peripheral(name, self.address, self.services()) as peripheral:
            while True:
                self._changed = anyio.Event()
                await self.send(peripheral)
                await self._changed.wait()

    def services(self) -> Mapping[str, tuple[GattValue, ...]]:
        """Return its services of GATT with their values; none by default."""
        return {}

    @abstractmethod
    async def send(self, peripheral: VirtualPeripheral) -> None:
        """Send the new state."""


class BluetoothLight(RadioDevice):
    """A light with two characteristics, one for commands and one for reports."""

    def services(self) -> Mapping[str, tuple[GattValue, ...]]:
        """Return the light's service and the device information."""
        return {
            LIGHT_SERVICE: (
                GattValue(LIGHT_COMMAND, read=self._value, write=self._write),
                GattValue(LIGHT_STATE, read=self._value, notifies=True),
            ),
            _INFORMATION: (
                GattValue("2A29", read=lambda: b"homebot"),
                GattValue("2A24", read=lambda: b"Simulated light"),
            ),
        }

    async def send(self, peripheral: VirtualPeripheral) -> None:
        """Notify the connected client and advertise to all others."""
        services = bytes.fromhex(LIGHT_SERVICE.replace("-", ""))[::-1]
        await peripheral.advertise([FLAGS, (_SERVICES_128, services), self.short_name], EVERY, connectable=True)
        await peripheral.notify(LIGHT_STATE, self._value())

    def _value(self) -> bytes:
        return bytes([self.state.is_on, round(self.state.brightness * 255)])

    def _write(self, data: bytes) -> None:
        if len(data) != len(self._value()):
            return
        is_on, level = data
        if not is_on or not level:
            self.on_command("off")
        elif level == self._value()[1]:
            self.on_command("on")
        else:
            self.on_command(f"{level / 255:.4f}")
