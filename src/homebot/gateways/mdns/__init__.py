"""The mDNS gateway: devices that announce themselves on the local network by DNS-SD."""

from homebot.gateways.mdns.gateway import MdnsGateway
from homebot.gateways.mdns.network import NetworkInterfaces
from homebot.gateways.mdns.settings import MdnsGatewaySettings

__all__ = ["MdnsGateway", "MdnsGatewaySettings", "NetworkInterfaces"]
