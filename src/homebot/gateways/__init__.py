"""The proxy layer: one gateway per protocol."""

from homebot.gateways.base import Gateway

__all__ = ["Gateway"]
