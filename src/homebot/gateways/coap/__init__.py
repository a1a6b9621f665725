"""The gateway for CoAP: devices that are found by multicast, in resource directories, or by their address."""

from homebot.gateways.coap.gateway import CoapGateway
from homebot.gateways.coap.settings import CoapGatewaySettings

__all__ = ["CoapGateway", "CoapGatewaySettings"]
