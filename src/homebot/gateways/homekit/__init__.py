"""The HomeKit gateway."""

from homebot.gateways.homekit.gateway import HomekitGateway
from homebot.gateways.homekit.settings import HomekitGatewaySettings

__all__ = ["HomekitGateway", "HomekitGatewaySettings"]
