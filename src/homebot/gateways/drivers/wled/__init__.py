"""The driver for WLED, firmware for light strips."""

from homebot.gateways.drivers.wled.driver import WledDriver

__all__ = ["WledDriver"]
