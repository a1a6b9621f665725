"""Drivers: how to talk to the devices that a gateway finds on the network, by their DNS-SD service type."""

from homebot.gateways.drivers.base import (
    Driver,
    DriverHost,
    DriverSession,
    DriverSettings,
    FoundService,
    SessionDriver,
)

__all__ = ["Driver", "DriverHost", "DriverSession", "DriverSettings", "FoundService", "SessionDriver"]
