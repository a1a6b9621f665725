"""The proxy layer: one gateway per protocol."""

from homebot.gateways.base import Gateway, GatewaySettings
from homebot.gateways.context import GatewayContext, HostService

__all__ = ["Gateway", "GatewayContext", "GatewaySettings", "HostService"]
