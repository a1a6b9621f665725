"""Addresses of hosts: which are this computer's own, and which belong to one owner. Pure."""

from __future__ import annotations

import ipaddress
from functools import lru_cache
from typing import Final

__all__ = ["ip_version", "is_loopback", "network_of"]

_IPV6_PREFIX: Final = 64
"""Bits of an IPv6 address that belong to one household or customer; the rest anybody may choose."""


def is_loopback(host: str) -> bool:
    """Return whether *host* is ``localhost`` or a loopback address; brackets around an IPv6 address are fine."""
    if host.lower() in {"localhost", "localhost."}:
        return True
    try:
        return ipaddress.ip_address(host.removeprefix("[").removesuffix("]")).is_loopback
    except ValueError:
        return False


def ip_version(host: str) -> int | None:
    """Return 4 or 6 where *host* is an address, which needs no look-up; None where it is a name."""
    try:
        return ipaddress.ip_address(host).version
    except ValueError:
        return None


@lru_cache(maxsize=1024)
def network_of(host: str) -> str:
    """Return what one owner has of addresses: an IPv4 address, the network of an IPv6 one; a name is left as it is."""
    try:
        known = ipaddress.ip_address(host.removeprefix("[").removesuffix("]").partition("%")[0])
    except ValueError:
        return host
    if isinstance(known, ipaddress.IPv4Address):
        return str(known)
    if known.ipv4_mapped is not None:
        return str(known.ipv4_mapped)
    return str(ipaddress.ip_network((known, _IPV6_PREFIX), strict=False))
