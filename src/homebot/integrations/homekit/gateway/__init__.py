"""The HomeKit gateway."""

from homebot.integrations.homekit.gateway.gateway import HomekitGateway, HomekitGatewaySettings

__all__ = ["HomekitGateway", "HomekitGatewaySettings"]
