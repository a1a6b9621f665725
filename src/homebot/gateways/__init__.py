"""The proxy layer: one gateway per protocol."""

from homebot.gateways.base import Gateway, GatewayState

__all__ = ["Gateway", "GatewayState"]
