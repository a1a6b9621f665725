"""A simulated device as a HomeKit accessory."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import anyio

from homebot.house.connected_device import ServedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.homekit.services import orders_of, values_of

if TYPE_CHECKING:
    from homebot.house.homekit.bridge import BridgedAccessory, SimulatedHomekitBridge

__all__ = ["ServedAccessory"]


class ServedAccessory(ServedDevice):
    """A lamp, window, cover, lock, thermostat or sensor behind the bridge of the house."""

    def __init__(
        self, device: SimulatedDeviceInfo, on_command: Callable[[str], None], bridge: SimulatedHomekitBridge
    ) -> None:
        super().__init__(device, on_command)
        self._bridge = bridge
        self._accessory: BridgedAccessory | None = None
        bridge.add(device, self._on_write)

    async def serve(self) -> None:
        """Be reachable by the bridge until cancelled."""
        self._accessory = await self._bridge.reach(self.device)
        self._accessory.is_there = True
        self.show()
        try:
            await anyio.sleep_forever()
        finally:
            self._accessory.is_there = False

    def show(self) -> None:
        """Report the characteristics that have changed."""
        if self._accessory is not None and self._accessory.is_there:
            self._accessory.show(values_of(self.device.kind, self.state))

    def _on_write(self, values: Mapping[str, float]) -> None:
        if self._accessory is not None and self._accessory.is_there:
            for order in orders_of(values):
                self.on_command(order)
