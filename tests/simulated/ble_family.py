"""The virtual radio of a house, and the family of simulated Bluetooth lights on it."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from random import Random

from homebot.house.family import FamilyNetwork, ServedFamily

LIGHT_PROFILE = {
    "service": "7b1d0001-6b8f-4f3e-9d2a-0123456789ab",
    "command": "7b1d0002-6b8f-4f3e-9d2a-0123456789ab",
    "state": "7b1d0003-6b8f-4f3e-9d2a-0123456789ab",
    **dict.fromkeys(("on", "off", "level", "report"), "{on}{level}"),
}
"""The profile of the simulated lights."""


class BleNetwork(FamilyNetwork):
    """A virtual radio, with an adapter for homebot."""

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table of a gateway by default."""
        return {"ble": {"profiles": {"light": LIGHT_PROFILE}}}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the radio; yield its adapter."""
        from tests.simulated import virtual_bleak, virtual_radio  # noqa: PLC0415 - an extra

        radio = virtual_radio.VirtualRadio(random)
        self.options["radio"] = radio
        async with radio.running():
            yield (virtual_bleak.backend_of(radio),)


class BleFamily(ServedFamily):
    """Devices on that radio."""

    network = BleNetwork


class BluetoothLightFamily(BleFamily):
    """Lights that are connected to."""

    kinds = frozenset({"lamp"})
    device = "tests.simulated.ble_devices:BluetoothLight"
