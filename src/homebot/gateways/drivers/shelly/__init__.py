"""The driver for Shelly's devices of the second generation and later."""

from homebot.gateways.drivers.shelly.driver import ShellyDriver, ShellyDriverSettings

__all__ = ["ShellyDriver", "ShellyDriverSettings"]
