"""A gateway's published devices, as the driver of one of them sees them."""

from __future__ import annotations

from collections.abc import Mapping

from structlog.typing import FilteringBoundLogger

from homebot.clock import Clock
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice
from homebot.gateways.announced.published_devices import PublishedDevices

__all__ = ["PublishedDriverHost"]


class PublishedDriverHost:
    """A :class:`homebot.gateways.drivers.base.DriverHost` for one device of a gateway.

    Args:
        devices: The devices of the gateway.
        key: The key of the device.
        clock: The clock to live by.
        log: The log of the gateway's node.

    Attributes:
        clock: The same.
        log: The same.
    """

    def __init__(self, devices: PublishedDevices, key: str, clock: Clock, log: FilteringBoundLogger) -> None:
        self.clock = clock
        self.log = log
        self._devices = devices
        self._key = key

    def describe(self, device: GatewayDevice) -> None:
        """Publish what the device is."""
        self._devices.put(device, "it described itself")

    async def report(self, values: Mapping[str, PlainValue], part: str = "") -> None:
        """Publish what a part reported."""
        await self._devices.report(self._key, values, part)

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device, or one of its parts, can be reached."""
        self._devices.report_reachable(self._key, part, reachable=reachable)

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device, to who listens to its address."""
        await self._devices.deliver_raw(self._key, payload)

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""
        self._devices.reject(self._key, payload, why)
