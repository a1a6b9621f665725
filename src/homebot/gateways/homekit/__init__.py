"""The HomeKit gateway."""

from homebot.gateways.homekit.gateway import HomekitGateway, HomekitGatewaySettings

__all__ = ["HomekitGateway", "HomekitGatewaySettings"]
