"""The gateway to Philips Hue bridges; the CLIP API v2."""

from homebot.integrations.hue.gateway.gateway import HueGateway, HueGatewaySettings

__all__ = ["HueGateway", "HueGatewaySettings"]
