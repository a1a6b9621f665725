"""The interface that a gateway offers to what connects to one device for it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Protocol

from structlog.typing import FilteringBoundLogger

from homebot.clock import Clock
from homebot.devices.value import PlainValue
from homebot.gateways.announced.gateway_device import GatewayDevice

__all__ = ["DriverHost"]


class DriverHost(Protocol):
    """The interface that a gateway offers to the driver of one service."""

    clock: Clock
    log: FilteringBoundLogger

    def describe(self, device: GatewayDevice) -> None:
        """Publish the description of the device, once it is known and on each change.

        Args:
            device: The device; its key is that of the service. Facts from DNS-SD are added by the gateway.
        """

    def describe_behind(self, devices: Iterable[GatewayDevice]) -> None:
        """Publish the descriptions of the devices that the device connects, in place of those before.

        They can be reached if the device can; each has a key of its own.
        """

    async def report(self, values: Mapping[str, PlainValue], part: str = "", key: str = "") -> None:
        """Publish a report of a part, in the units of the vocabulary; values that it cannot have are refused.

        Args:
            key: The key of a device behind the device; empty for the device itself.
        """

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device with all behind it, or one of its parts, can be reached.

        The gateway does so for the connection.
        """

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the subscribers of its address."""

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""
