"""The gateway to Matter, through the WebSocket of a Matter server; experimental."""

from homebot.gateways.matter.gateway import MatterGateway, MatterGatewaySettings

__all__ = ["MatterGateway", "MatterGatewaySettings"]
