"""The table ``[gateways.NAME]`` of an mDNS gateway."""

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated

from pydantic import Field, PrivateAttr, field_validator

from homebot.config import folder_of
from homebot.conventions.dns_sd import ENUMERATION, full_type, is_service_type
from homebot.gateways.base import GatewaySettings
from homebot.units import Seconds

KNOWN_TYPES = tuple(
    f"{name}.local."
    for name in (
        "_airplay._tcp",
        "_googlecast._tcp",
        "_homebot._tcp",
        "_http._tcp",
        "_ipp._tcp",
        "_mqtt._tcp",
        "_rosbridge._tcp",
        "_wot._tcp",
    )
)
"""The types that are queried at once, besides those of drivers and ecosystems; others are found by querying the list of
all types first."""


class MdnsGatewaySettings(GatewaySettings):
    """The settings of an mDNS gateway.

    Attributes:
        interfaces: The network interfaces to use, by name or address; by default all but loopback.
        service_types: The DNS-SD service types to look for, such as ``_http._tcp``. By default those of all drivers,
            some that are common in houses, and every further one on the network, which
            ``_services._dns-sd._udp`` stands for.
        announce: Whether homebot announces itself on the network.
        announce_as: The name that it announces; by default that of this computer.
        drivers: The tables of drivers by their names. A driver that is installed needs none; one of your own is named
            ``module:Class``.
        sleeping: Devices that sleep to save their battery and do not say so: the seconds of silence after which each
            counts as stale, by the instance names of their services: ``{ "garden" = 7200 }``.
        forget_sleeping_after: Seconds after which a sleeping device that did not come back is removed.
        max_services: Services that may be known at once; of one type at most half of them.
    """

    interfaces: tuple[str, ...] = ()
    service_types: tuple[str, ...] | None = None
    announce: bool = True
    announce_as: Annotated[str, Field(max_length=63)] = ""
    drivers: Mapping[str, Mapping[str, object]] = Field(default_factory=dict)
    sleeping: Mapping[str, Seconds] = Field(default_factory=dict)
    forget_sleeping_after: Seconds = 604_800.0
    max_services: Annotated[int, Field(ge=2, le=10_000)] = 1000
    _folder: Path = PrivateAttr(default_factory=Path)

    @field_validator("service_types")
    @classmethod
    def _check_types(cls, types: tuple[str, ...] | None) -> tuple[str, ...] | None:
        if types is None:
            return None
        full = tuple(full_type(service_type) for service_type in types)
        for given, service_type in zip(types, full, strict=True):
            if not is_service_type(service_type):
                raise ValueError(f"{given!r} is not a service type; write it like _http._tcp")
        return full

    def model_post_init(self, context: object) -> None:
        """Remember the folder of the configuration for the tables of drivers, which are checked later."""
        self._folder = folder_of(context)

    @property
    def folder(self) -> Path:
        """The folder that relative paths in the tables of drivers start from."""
        return self._folder

    def types_with(self, known: Iterable[str]) -> frozenset[str]:
        """Return the service types to look for, given the types that drivers and ecosystems have."""
        if self.service_types is not None:
            return frozenset(self.service_types)
        return frozenset((*known, *KNOWN_TYPES, ENUMERATION))
