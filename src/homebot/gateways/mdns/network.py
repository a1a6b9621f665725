"""The port to the network: news of services, their records, and the services that homebot announces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, Protocol

from homebot.conventions.dns_sd.found_service import FoundService

__all__ = ["OwnService", "ResolvedService", "ServiceNetwork", "ServiceNews"]


@dataclass(frozen=True, slots=True)
class ServiceNews:
    """News of a service on the network.

    Attributes:
        kind: ``seen`` (announced, or changed), or ``gone`` (it said goodbye).
        service_type: Its type in full.
        name: Its name in full.
    """

    kind: Literal["seen", "gone"]
    service_type: str
    name: str


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
        properties: Its TXT record.
    """

    service_type: str
    name: str
    host: str
    port: int
    addresses: tuple[str, ...] = ()
    properties: Mapping[str, str] = field(default_factory=dict)


class ServiceNetwork(Protocol):
    """The port to the network; :class:`homebot.gateways.mdns.zeroconf_network.MdnsNetwork` is the adapter."""

    def resolve_cached(self, service_type: str, name: str) -> ResolvedService | None:
        """Return a service from cached records; None if some are missing or expired."""

    async def resolve(self, service_type: str, name: str, within: float) -> ResolvedService | None:
        """Ask for the records of a service; return None if it does not answer *within* that many seconds."""

    def forget(self, service_type: str, name: str) -> None:
        """Drop the cached records of a service, so that its next announcement is news."""

    def cached_names(self, service_type: str) -> tuple[str, ...]:
        """Return the names of the services of a type that were announced and not withdrawn."""

    async def ask_again(self) -> None:
        """Ask for all types again."""

    async def announce(self, service: OwnService) -> str:
        """Announce a service of homebot; return the name that it got.

        Raises:
            LinkError: It cannot be announced.
        """

    async def withdraw(self, service_type: str) -> None:
        """Withdraw a service of homebot."""
