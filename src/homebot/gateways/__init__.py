"""The proxy layer: one gateway per protocol."""

from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings, HostService

__all__ = ["Gateway", "GatewayContext", "GatewaySettings", "HostService"]
