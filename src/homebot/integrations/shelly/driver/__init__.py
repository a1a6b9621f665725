"""The driver for Shelly's devices of the second generation and later."""

from homebot.integrations.shelly.driver.driver import ShellyDriver, ShellyDriverSettings

__all__ = ["ShellyDriver", "ShellyDriverSettings"]
