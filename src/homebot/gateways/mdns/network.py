"""The port to the network: its interfaces, news of services, their records, and the services of homebot.

The only file that imports ifaddr.
"""

from __future__ import annotations

import ipaddress
import socket
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, Protocol, TypeAlias

import anyio

from homebot.conventions.dns_sd import FoundService

if TYPE_CHECKING:
    from ifaddr import Adapter

Interfaces: TypeAlias = tuple[str | int, ...]
"""IPv4 addresses, and the indexes of interfaces that have IPv6: as zeroconf wants them."""

LOOK_EVERY = 2.0
"""Seconds between two checks of the interfaces; one check takes about 0.2 ms."""


@dataclass(frozen=True, slots=True)
class ServiceNews:
    """News of a service on the network.

    Attributes:
        kind: ``seen`` (announced, or changed), or ``gone`` (it said goodbye).
        sender: The network address that told it; empty if it was in the cache.
    """

    kind: Literal["seen", "gone"]
    service_type: str
    name: str
    sender: str = ""


@dataclass(frozen=True, slots=True)
class ResolvedService:
    """A service with known records.

    Attributes:
        ttl: The time to live of its SRV record, in seconds.
        left: The seconds of it that are left.
        problem: The rule that its records break, as text; empty for none.
    """

    service: FoundService
    ttl: float
    left: float
    problem: str = ""
    txt: bytes = b""


@dataclass(frozen=True, slots=True)
class OwnService:
    """A service that homebot announces.

    Attributes:
        service_type: Its type, such as ``_homebot._tcp``, perhaps with a subtype.
        host: The label of its host name.
        port: Its port; 0 if there is nothing to connect to.
        addresses: The addresses that it listens on; empty for all of this computer.
    """

    service_type: str
    name: str
    host: str
    port: int
    addresses: tuple[str, ...] = ()
    properties: Mapping[str, str] = field(default_factory=dict)


class ServiceNetwork(Protocol):
    """The port to the services on the network; :class:`homebot.gateways.mdns.zeroconf_network.MdnsNetwork` is it."""

    def resolve_cached(self, service_type: str, name: str) -> ResolvedService | None:
        """Return a service from cached records; None if some are missing or expired."""

    async def resolve(self, service_type: str, name: str, within: float) -> ResolvedService | None:
        """Ask for the records of a service; return None if it does not answer *within* that many seconds."""

    def forget(self, service_type: str, name: str) -> None:
        """Drop the cached records of a service, so that its next announcement is news."""

    async def ask_again(self, service_types: Collection[str] | None = None) -> None:
        """Ask for these types again, by default for all."""


class NetworkInterfaces:
    """The network interfaces of this computer; the host may provide others."""

    def find(self, wanted: tuple[str, ...]) -> Interfaces:
        """Return the present interfaces that are *wanted* by name or address; if that is empty, all but loopback."""
        import ifaddr  # noqa: PLC0415 - an extra

        interfaces = (interface for adapter in ifaddr.get_adapters() for interface in _wanted_of(adapter, wanted))
        return tuple(dict.fromkeys(interfaces))

    async def wait_for_change(self, wanted: tuple[str, ...], before: Interfaces) -> Interfaces:
        """Wait until the interfaces differ from *before*, and return them."""
        while (now := self.find(wanted)) == before:  # noqa: ASYNC110 - the system sends no event
            await anyio.sleep(LOOK_EVERY)
        return now


def _wanted_of(adapter: Adapter, wanted: tuple[str, ...]) -> list[str | int]:
    """Return the wanted IPv4 addresses of *adapter*, and its index if IPv6 is wanted and usable."""
    texts = [ip.ip if isinstance(ip.ip, str) else ip.ip[0] for ip in adapter.ips]
    addresses = list(map(ipaddress.ip_address, texts))
    is_wanted = adapter.name in wanted if wanted else not any(address.is_loopback for address in addresses)
    named = texts if is_wanted else [text for text in texts if text in wanted]
    interfaces: list[str | int] = [text for text in named if ":" not in text]
    if len(interfaces) < len(named) and adapter.index is not None and _has_link_local(addresses, adapter.index):
        interfaces.append(adapter.index)
    return interfaces


def _has_link_local(addresses: Sequence[ipaddress.IPv4Address | ipaddress.IPv6Address], index: int) -> bool:
    """Return whether an interface has a usable link-local address: duplicate detection takes some seconds."""
    local = next((str(address) for address in addresses if address.version == 6 and address.is_link_local), None)
    if local is None:
        return False
    with socket.socket(socket.AF_INET6, socket.SOCK_DGRAM) as probe:
        try:
            probe.bind((local, 0, 0, index))
        except OSError:
            return False
    return True
