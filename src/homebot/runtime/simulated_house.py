"""The parts of a simulated house that a runtime needs; the code of the house is loaded where there is one."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from homebot.errors import ConfigError
from homebot.gateways import HostService
from homebot.runtime.plan import Plan

if TYPE_CHECKING:
    from homebot.house import World
    from homebot.house.network import HouseNetwork

__all__ = ["check_hosts_house", "network_of", "real_gateways"]


def network_of(house: World) -> HouseNetwork:
    """Return the network that the devices of *house* are on."""
    from homebot.house.network import HouseNetwork  # noqa: PLC0415 - only for simulated houses

    return HouseNetwork(house.families())


def real_gateways(plan: Plan, own: frozenset[str]) -> list[str]:
    """Return the gateways among the configured ones, *own*, that may find devices outside the simulated house."""
    from homebot.house import SimulatedHouse  # noqa: PLC0415 - as above

    return [
        one.name
        for one in plan.gateways
        if one.name in own
        and all(service.kind is not SimulatedHouse.Host for service in one.kind.host_services(one.settings))
    ]


def check_hosts_house(needed: Iterable[HostService[object]], source: str) -> None:
    """Check that there is an embedded broker for the devices of a simulated house.

    Raises:
        ConfigError: No in-process peer of this name exists.
    """
    from homebot.house import SimulatedHouse  # noqa: PLC0415 - as above

    if all(service.kind is not SimulatedHouse.Host for service in needed):
        raise ConfigError(source, "gateways", SimulatedHouse.WITHOUT_HOST)
