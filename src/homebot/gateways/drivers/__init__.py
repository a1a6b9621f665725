"""Drivers: how to talk to the devices that a gateway finds on the network, by their DNS-SD service type."""

from homebot.gateways.announced.device_runner import DriverHost
from homebot.gateways.drivers.base import Driver, DriverSettings, FoundService

__all__ = ["Driver", "DriverHost", "DriverSettings", "FoundService"]
