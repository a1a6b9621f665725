"""The interface that a gateway offers to what connects to one device for it."""

from __future__ import annotations

from collections.abc import Mapping
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

    async def report(self, values: Mapping[str, PlainValue], part: str = "") -> None:
        """Publish a report of a part, in the units of the vocabulary; values that it cannot have are refused."""

    def report_reachable(self, *, reachable: bool | None, part: str = "") -> None:
        """Publish whether the device, or one of its parts, can be reached; the gateway does so for the connection."""

    async def deliver_raw(self, payload: bytes) -> None:
        """Deliver a raw message of the device to the subscribers of its address."""

    def reject(self, payload: bytes, why: str) -> None:
        """Count a message of the device that breaks the rules of its protocol, and log it now and then."""
