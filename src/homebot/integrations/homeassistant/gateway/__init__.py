"""The gateway to Home Assistant, over its WebSocket."""

from homebot.integrations.homeassistant.gateway.gateway import HomeAssistantGateway
from homebot.integrations.homeassistant.gateway.settings import HomeAssistantGatewaySettings

__all__ = ["HomeAssistantGateway", "HomeAssistantGatewaySettings"]
