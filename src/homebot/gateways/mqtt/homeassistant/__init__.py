"""Devices that announce themselves as Home Assistant wants it (MQTT discovery)."""

from homebot.gateways.mqtt.homeassistant.convention import HomeAssistantDiscovery, HomeAssistantSettings

__all__ = ["HomeAssistantDiscovery", "HomeAssistantSettings"]
