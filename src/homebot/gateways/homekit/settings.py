"""The table ``[gateways.NAME]`` of a HomeKit gateway."""

from __future__ import annotations

from homebot.config import FilePath
from homebot.gateways.base import GatewaySettings

__all__ = ["HomekitGatewaySettings"]


class HomekitGatewaySettings(GatewaySettings):
    """The settings of a HomeKit gateway.

    Attributes:
        mdns: The name of the mDNS gateway, which finds the accessories.
        pairings: File with the keys of paired accessories, readable by its owner only. By default
            ``NAME.pairings.json``, with the gateway's name, beside homebot's index.
    """

    mdns: str = "mdns"
    pairings: FilePath | None = None
