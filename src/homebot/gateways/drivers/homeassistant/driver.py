"""The driver of a Home Assistant that DNS-SD announces: it says how to let homebot use it.

Source: Home Assistant core 2024.3, ``components/zeroconf/__init__.py``.
"""

from __future__ import annotations

from typing import ClassVar

import anyio

from homebot.conventions.homeassistant.states import HOW_TO_LOG_IN
from homebot.devices.gateway_messages import Command
from homebot.errors import UnableError
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.drivers.base import Driver

__all__ = ["HomeAssistantDriver"]

FOUND = "homeassistant.found"


class HomeAssistantDriver(Driver):
    """Names the next step, in the log and as a fact of the device; it connects to nothing."""

    service_types: ClassVar[frozenset[str]] = frozenset({"_home-assistant._tcp.local."})

    async def run(self) -> None:
        """Describe it until cancelled."""
        told = self.service.properties
        name = told.get("location_name") or self.service.name
        default = f"http://{self.service.host.rstrip('.')}:{self.service.port}"
        url = told.get("internal_url") or told.get("base_url") or default
        step = f'set url = "{url[:200]}" in [gateways.homeassistant]; {HOW_TO_LOG_IN}'
        self.host.log.info(FOUND, message=f"found the Home Assistant {name!r}; to use its devices, {step}")
        facts = {"sw_version": told.get("version", ""), "next_step": step}
        self.host.describe(GatewayDevice(self.service.key, f"Home Assistant {name}", metadata=facts))
        await anyio.sleep_forever()

    async def perform(self, command: Command) -> None:
        """Refuse: its devices are those of its gateway."""
        raise UnableError(f"{command.capability[:40]}: the devices of {self.service.name} need its own gateway")
