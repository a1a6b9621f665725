"""The driver for a Home Assistant that DNS-SD announces."""

from homebot.gateways.drivers.homeassistant.driver import HomeAssistantDriver

__all__ = ["HomeAssistantDriver"]
