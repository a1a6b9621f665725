"""The table ``[gateways.NAME]`` of a gateway to Hue bridges."""

from __future__ import annotations

from typing import Annotated

from pydantic import AfterValidator

from homebot.config import FilePath
from homebot.errors import WireError
from homebot.gateways.base import GatewaySettings
from homebot.gateways.http_address import parse_url

__all__ = ["HueGatewaySettings"]


def _check_address(address: str) -> str:
    try:
        if parse_url(f"https://{address}").raw_path_qs == "/":
            return address
    except WireError:
        pass
    raise ValueError(f"{address!r} is no address of a bridge; write it like 192.168.1.20")


class HueGatewaySettings(GatewaySettings):
    """The settings of a gateway to Hue bridges.

    Attributes:
        bridges: Addresses of bridges that are not found by DNS-SD, such as ``192.168.1.20``.
        found_by: The mDNS gateway that finds the others.
        pairings: The file with the keys of paired bridges; by default one beside the index.
    """

    bridges: tuple[Annotated[str, AfterValidator(_check_address)], ...] = ()
    found_by: str = "mdns"
    pairings: FilePath | None = None
