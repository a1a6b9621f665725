"""The gateway to Matter, through the WebSocket of a Matter server; experimental."""

from homebot.integrations.matter.gateway.gateway import MatterGateway, MatterGatewaySettings

__all__ = ["MatterGateway", "MatterGatewaySettings"]
