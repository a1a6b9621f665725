"""Context of a gateway, given by the program that runs it."""

from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager
from dataclasses import dataclass, field
from random import Random
from typing import Generic, Self, TypeVar

from homebot.clock import Clock
from homebot.graph import Graph

__all__ = ["GatewayContext", "HostService"]

ServiceT = TypeVar("ServiceT")
ServiceT_co = TypeVar("ServiceT_co", covariant=True)


@dataclass(frozen=True, slots=True)
class HostService(Generic[ServiceT_co]):
    """A service that gateways share in this process, such as the embedded broker.

    Attributes:
        kind: The class of the running service, its key in a :class:`GatewayContext`.
        start: Runs it; the context is entered when it is ready, and stops it when left.
    """

    kind: type[ServiceT_co]
    start: Callable[[Graph, Clock], AbstractAsyncContextManager[ServiceT_co]]


@dataclass(frozen=True, slots=True, eq=False)
class GatewayContext:
    """The surroundings of a gateway beside its node and settings; its clock is that of the node's graph.

    Attributes:
        random: The source of random numbers, seeded for reproducible runs; None for the gateway's own.
        services: The running host services by their class.
        is_dry_run: Whether nothing may be sent; gateways then accept commands without sending them.
        gateways: The plug-ins of all configured gateways; None if they are unknown.
    """

    random: Random | None = None
    services: Mapping[type[object], object] = field(default_factory=dict)
    is_dry_run: bool = False
    gateways: frozenset[str] | None = None

    @classmethod
    def of(cls, *services: object, random: Random | None = None, is_dry_run: bool = False) -> Self:
        """Return a context with these running *services*."""
        return cls(random, {type(service): service for service in services}, is_dry_run)

    def service(self, kind: type[ServiceT]) -> ServiceT | None:
        """Return the running host service of the class *kind*, or None."""
        found = self.services.get(kind)
        return found if isinstance(found, kind) else None
