"""The table ``[gateways.NAME]`` of a gateway to Hue bridges."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from homebot.config import FilePath
from homebot.gateways.base import GatewaySettings

__all__ = ["HueGatewaySettings"]


class HueGatewaySettings(GatewaySettings):
    """The settings of a gateway to Hue bridges.

    Attributes:
        bridges: Addresses of bridges that are not found by DNS-SD, such as ``192.168.1.20``.
        mdns: The name of the mDNS gateway that finds the others.
        pairings: The file with the keys of paired bridges; by default one beside the index.
    """

    bridges: tuple[Annotated[str, Field(pattern=r"^[^/?#@\s]+$")], ...] = ()
    mdns: str = "mdns"
    pairings: FilePath | None = None
