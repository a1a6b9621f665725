"""Devices that announce themselves as Home Assistant wants it (MQTT discovery)."""

from homebot.integrations.homeassistant.formats.convention import HomeAssistantDiscovery, HomeAssistantSettings

__all__ = ["HomeAssistantDiscovery", "HomeAssistantSettings"]
