"""Addresses of hosts: those of this computer, and those of one owner. Pure."""

import ipaddress
from functools import lru_cache
from typing import Final
from urllib.parse import urljoin, urlsplit

_IPV6_PREFIX: Final = 64
"""Bits of an IPv6 address that identify one household; the rest can be chosen freely."""


def parse_address(host: str) -> ipaddress.IPv4Address | ipaddress.IPv6Address | None:
    """Return *host* as an address, IPv4 also if it is mapped into IPv6; None for a name.

    An IPv6 address may have brackets; its scope is dropped.
    """
    try:
        known = ipaddress.ip_address(host.removeprefix("[").removesuffix("]").partition("%")[0])
    except ValueError:
        return None
    mapped = known.ipv4_mapped if isinstance(known, ipaddress.IPv6Address) else None
    return mapped or known


def is_loopback(host: str) -> bool:
    """Return whether *host* is ``localhost`` or a loopback address."""
    known = parse_address(host)
    return host.lower() in {"localhost", "localhost."} if known is None else known.is_loopback


def ip_version(host: str) -> int | None:
    """Return 4 or 6 if *host* is an address; None if it is a name."""
    try:
        return ipaddress.ip_address(host).version
    except ValueError:
        return None


@lru_cache(maxsize=1024)
def network_of(host: str) -> str:
    """Return the addresses of one owner: an IPv4 address, the network of an IPv6 one, or a name."""
    known = parse_address(host)
    if known is None:
        return host
    if isinstance(known, ipaddress.IPv4Address):
        return str(known)
    return str(ipaddress.ip_network((known, _IPV6_PREFIX), strict=False))


def resolve_uri(base: str, href: str) -> str:
    """Return *href* resolved against *base* by RFC 3986, section 5.2, for any scheme, unlike Python's function.

    Raises:
        ValueError: One of the two is invalid.
    """
    scheme, separator, rest = base.partition("://")
    if urlsplit(href).scheme or not separator:
        return href
    return f"{scheme}:{urljoin(f'http://{rest}', href).removeprefix('http:')}"
