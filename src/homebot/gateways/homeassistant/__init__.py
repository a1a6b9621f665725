"""The gateway to Home Assistant, over its WebSocket."""

from homebot.gateways.homeassistant.gateway import HomeAssistantGateway
from homebot.gateways.homeassistant.settings import HomeAssistantGatewaySettings

__all__ = ["HomeAssistantGateway", "HomeAssistantGatewaySettings"]
