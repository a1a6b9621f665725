"""The gateway to Philips Hue bridges; the CLIP API v2."""

from homebot.gateways.hue.gateway import HueGateway, HueGatewaySettings

__all__ = ["HueGateway", "HueGatewaySettings"]
