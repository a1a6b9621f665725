"""Families of simulated devices: how their devices speak, and the network that they need.

A family is a :class:`~homebot.house.dialect.Dialect` for devices on MQTT, or a :class:`ServedFamily` for servers and
radios, which the gateway of their protocol finds. An integration offers its own as ``homebot.simulated``; others are
named as ``module:Class``.
"""

import socket
from abc import ABC
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from functools import lru_cache
from random import Random
from types import MappingProxyType
from typing import ClassVar, Final

from homebot.errors import PluginError
from homebot.house.dialect import Dialect
from homebot.plugins import has_plugin, load_plugin, plugin_names

GROUP: Final = "homebot.simulated"
LOOPBACK: Final = "127.0.0.1"

ALL_KINDS: Final = frozenset(
    {"contact", "cover", "lamp", "lock", "lux", "motion", "power_meter", "thermostat", "window"}
)
"""All kinds of devices but presence sensors, robots and tags."""


class FamilyNetwork:
    """The network that the devices of one or several families share: a radio, a hub, or the loopback interface.

    Attributes:
        options: Arguments of the classes of its devices, while it runs.
    """

    def __init__(self) -> None:
        self.options: dict[str, object] = {}

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the tables of the gateways that find its devices, by the names of their plug-ins."""
        return {}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run inside the block; yield the services that its gateways need."""
        del random
        yield ()


class LoopbackMdns(FamilyNetwork):
    """The loopback interface, on which devices announce themselves by mDNS."""

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table of a gateway that listens there alone."""
        return {"mdns": {"interfaces": [LOOPBACK], "announce": False}}


class ServedFamily(ABC):
    """A family of devices that are servers or radios. Importing it imports none of its libraries.

    Attributes:
        kinds: Its kinds of devices, as named in descriptions of houses.
        device: Module and class of its devices, ``module:Class``.
        options: Arguments of that class besides the device, the receiver of commands, and those of the network.
        network: The class of its network.
    """

    kinds: ClassVar[frozenset[str]]
    device: ClassVar[str]
    options: ClassVar[Mapping[str, object]] = MappingProxyType({})
    network: ClassVar[type[FamilyNetwork]]


def family_names() -> tuple[str, ...]:
    """Return the names of all installed families, sorted."""
    return plugin_names(GROUP)


@lru_cache(maxsize=100)
def family_of(name: str) -> Dialect | type[ServedFamily] | None:
    """Return the family *name*, which may also be ``module:Class``; None if none is installed.

    Raises:
        PluginError: It cannot be loaded.
    """
    if ":" not in name and not has_plugin(GROUP, name):
        return None
    kind = load_plugin(GROUP, name)
    if issubclass(kind, ServedFamily):
        return kind
    if issubclass(kind, Dialect):
        return kind()
    raise PluginError(name, f"is {kind.__name__}, neither a Dialect nor a ServedFamily")


def dialects() -> dict[str, Dialect]:
    """Return the installed families on MQTT by their names."""
    families = ((name, family_of(name)) for name in family_names())
    return {name: family for name, family in families if isinstance(family, Dialect)}


def announces(name: str) -> bool:
    """Return whether devices of the family *name* announce themselves, and so have names and identifiers."""
    family = family_of(name)
    return not isinstance(family, Dialect) or family.announces


def kinds_of(name: str) -> frozenset[str] | None:
    """Return the kinds of devices in the family *name*, or None if it does not exist."""
    family = family_of(name)
    return None if family is None else family.kinds


def free_port(kind: socket.SocketKind, host: str = LOOPBACK) -> int:
    """Return a free port of *host*."""
    with socket.socket(socket.AF_INET6 if ":" in host else socket.AF_INET, kind) as probe:
        probe.bind((host, 0))
        return int(probe.getsockname()[1])
