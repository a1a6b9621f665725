"""One of the devices that a gateway publishes, for code that works with that one alone."""

from __future__ import annotations

from collections.abc import Mapping

from structlog.typing import FilteringBoundLogger

from homebot.clock import Clock
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices

__all__ = ["PublishedDevice"]


class PublishedDevice:
    """One device of a gateway; it is a :class:`homebot.gateways.drivers.base.DriverHost`."""

    def __init__(self, devices: PublishedDevices, key: str, clock: Clock, log: FilteringBoundLogger) -> None:
        self.clock = clock
        self.log = log
        self.key = key
        self._devices = devices

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device."""
        self._devices.put(device, "it described itself")

    async def report(self, values: Mapping[str, PlainValue], part: str = "") -> None:
        """Publish the reported values of a part."""
        await self._devices.report(self.key, values, part)

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device, or one of its parts, can be reached."""
        self._devices.report_reachable(self.key, part, reachable=reachable)

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the listeners of its address."""
        await self._devices.deliver_raw(self.key, payload)

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""
        self._devices.reject(self.key, payload, why)
