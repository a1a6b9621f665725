"""Simulated Bluetooth devices that broadcast BTHome v2: sensors, and a button.

Source: https://bthome.io/format.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping

import anyio
from tests.simulated.ble_devices import EVERY, FLAGS, RadioDevice
from tests.simulated.virtual_radio import VirtualPeripheral, VirtualRadio

from homebot.errors import UsageError
from homebot.house.dialect import DeviceState, SimulatedDeviceInfo
from homebot.integrations.bthome.formats.encryption import seal

PRESS_LASTS = 2.0
"""Seconds for which a button advertises that it was pressed."""

PRESSES: Mapping[str, int] = {"single": 1, "double": 2, "triple": 3, "long": 4}
_SERVICE_DATA = 0x16
_BTHOME = b"\xd2\xfc"


class _BTHomeDevice(RadioDevice):
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
        await peripheral.advertise([FLAGS, (_SERVICE_DATA, _BTHOME + data), self.short_name], EVERY, connectable=False)


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
