"""Simulated Bluetooth devices: sensors that broadcast BTHome v2, a button, and a light that is connected to.

Sources: https://bthome.io/format; the light's service is of homebot's own making: a characteristic that takes two
bytes, whether it is on and how bright (0 to 255), and one that reports them.
"""

import hashlib
from abc import abstractmethod
from collections.abc import Callable, Mapping

import anyio

from homebot.conventions.bthome.encryption import seal
from homebot.errors import UsageError
from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.house.virtual_radio import GattValue, VirtualPeripheral, VirtualRadio

__all__ = ["BluetoothLight", "BroadcastingButton", "BroadcastingSensor", "address_of"]

EVERY = 1.0
"""Seconds between advertisements."""

PRESS_LASTS = 2.0
"""Seconds for which a button advertises that it was pressed."""

PRESSES: Mapping[str, int] = {"single": 1, "double": 2, "triple": 3, "long": 4}
LIGHT_SERVICE = "7b1d0001-6b8f-4f3e-9d2a-0123456789ab"
LIGHT_COMMAND = "7b1d0002-6b8f-4f3e-9d2a-0123456789ab"
LIGHT_STATE = "7b1d0003-6b8f-4f3e-9d2a-0123456789ab"
_INFORMATION = "180A"
_FLAGS = (0x01, b"\x06")
_SERVICE_DATA = 0x16
_SERVICES_128 = 0x07
_NAME = 0x09
_BTHOME = b"\xd2\xfc"
_NAME_BYTES = 10
"""Room for a name in 31 bytes."""


def address_of(name: str) -> str:
    """Return the address of the device *name*: random static, the same in every run."""
    digits = bytearray(hashlib.sha256(name.encode()).digest()[:6])
    digits[0] |= 0xC0
    return digits.hex(":").upper()


class _RadioDevice(ServedDevice):
    def __init__(self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], radio: VirtualRadio) -> None:
        super().__init__(device, on_command)
        self.radio = radio
        self.address = address_of(device.device_id)
        self._changed = anyio.Event()
        self._name = _NAME, device.device_id.encode()[:_NAME_BYTES].decode(errors="ignore").encode()

    def show(self) -> None:
        self._changed.set()

    async def serve(self) -> None:
        name = self.device.device_id
        async with self.radio.peripheral(name, self.address, self.services()) as peripheral:
            while True:
                self._changed = anyio.Event()
                await self.send(peripheral)
                await self._changed.wait()

    def services(self) -> Mapping[str, tuple[GattValue, ...]]:
        return {}

    @abstractmethod
    async def send(self, peripheral: VirtualPeripheral) -> None:
        """Send the new state."""


class _BTHomeDevice(_RadioDevice):
    """A device that broadcasts BTHome v2.

    Args:
        bind_key: The encryption key; empty for none.
    """

    is_trigger_based = False

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], radio: VirtualRadio, bind_key: bytes = b""
    ) -> None:
        super().__init__(device, on_command, radio)
        self.bind_key = bind_key
        self._count = 0

    async def send(self, peripheral: VirtualPeripheral) -> None:
        await self._advertise(peripheral, self.objects())

    @abstractmethod
    def objects(self) -> bytes:
        """Return the objects of the state, in ascending order of their ids."""

    async def _advertise(self, peripheral: VirtualPeripheral, objects: bytes) -> None:
        self._count += 1
        body = bytes([0x00, self._count % 256]) + objects
        flags = 0x44 if self.is_trigger_based else 0x40
        data = bytes([flags]) + body
        if self.bind_key:
            address = bytes.fromhex(self.address.replace(":", ""))
            data = seal(self.bind_key, address, flags | 1, self._count, body)
        await peripheral.advertise([_FLAGS, (_SERVICE_DATA, _BTHOME + data), self._name], EVERY, connectable=False)


class BroadcastingSensor(_BTHomeDevice):
    """A contact, a motion sensor, a light sensor, a power meter or a thermometer that broadcasts BTHome v2.

    Raises:
        UsageError: It is of another kind.
    """

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], radio: VirtualRadio, bind_key: bytes = b""
    ) -> None:
        if device.kind not in _OBJECTS:
            raise UsageError(f"{device.kind!r} does not broadcast BTHome; these do: {', '.join(_OBJECTS)}")
        super().__init__(device, on_command, radio, bind_key)

    def objects(self) -> bytes:
        """Return the measurements."""
        return _OBJECTS[self.device.kind](self.state)


class BroadcastingButton(_BTHomeDevice):
    """A button that broadcasts BTHome v2 when it is pressed, and nothing before that."""

    is_trigger_based = True
    _press = 0

    def press(self, how: str) -> None:
        """Send a press.

        Args:
            how: ``single``, ``double``, ``triple`` or ``long``.
        """
        self._press = PRESSES[how]
        self.show()

    async def send(self, peripheral: VirtualPeripheral) -> None:
        """Advertise a press for a moment."""
        if not self._press:
            return
        objects, self._press = self.objects(), 0
        await self._advertise(peripheral, objects)
        await anyio.sleep(PRESS_LASTS)
        await peripheral.advertise_nothing()

    def objects(self) -> bytes:
        """Return the press."""
        return bytes([0x01, 100, 0x3A, self._press])


class BluetoothLight(_RadioDevice):
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
        await peripheral.advertise([_FLAGS, (_SERVICES_128, services), self._name], EVERY, connectable=True)
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


def _little(number: float, size: int) -> bytes:
    whole = round(number)
    return whole.to_bytes(size, "little", signed=whole < 0)


_OBJECTS: Mapping[str, Callable[[DeviceState], bytes]] = {
    "contact": lambda state: bytes([0x01, 100, 0x2D, state.text == "open"]),
    "motion": lambda state: bytes([0x01, 100, 0x21, state.text == "motion"]),
    "lux": lambda state: b"\x01\x64\x05" + _little(state.value * 100, 3),
    "power_meter": lambda state: b"\x0b" + _little(state.value * 100, 3),
    "thermostat": lambda state: b"\x01\x64\x02" + _little(state.celsius * 100, 2),
}
"""Broadcast objects by kind: the battery, if any, and the measurements."""
