"""The proxy layer: one gateway per protocol."""

from homebot.gateways.base import Gateway, GatewayContext, GatewaySettings, HostService
from homebot.support.lazy_names import lazy_names

TYPE_CHECKING = False
if TYPE_CHECKING:
    from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
    from homebot.gateways.announced.published_devices import PublishedDevices

__all__ = [
    "Gateway",
    "GatewayContext",
    "GatewayDevice",
    "GatewaySettings",
    "HostService",
    "PublishedDevices",
    "simple_part",
]

if not TYPE_CHECKING:  # else a type checker would accept any name
    __getattr__ = lazy_names(
        __name__,
        {
            "homebot.gateways.announced.gateway_device": "GatewayDevice simple_part",
            "homebot.gateways.announced.published_devices": "PublishedDevices",
        },
    )
