"""A service that was found on the network. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["FoundService"]


@dataclass(frozen=True, slots=True)
class FoundService:
    """A service that was found on the network (RFC 6763).

    Attributes:
        key: Its full name, ``Hall._shelly._tcp.local.``: the key of the device at the gateway.
        name: Its instance name, for people: ``Hall``.
        service_type: ``_shelly._tcp.local.``
        host: The name of its host: ``shellyplus1-a8032abe54dc.local.``
        port: Its port, 1 to 65535.
        addresses: The addresses of its host, best first: IPv4, then IPv6, link-local ones with their scope.
        properties: The keys and values of its TXT record, as text; keys are lower case.
    """

    key: str
    name: str
    service_type: str
    host: str
    port: int
    addresses: tuple[str, ...]
    properties: Mapping[str, str] = field(default_factory=dict)
