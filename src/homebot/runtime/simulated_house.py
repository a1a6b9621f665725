"""The simulated house of a run; the code of the house is loaded with this module."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from contextlib import AbstractAsyncContextManager
from random import Random
from typing import final

import anyio
from anyio.abc import TaskStatus

from homebot.clock import Clock
from homebot.errors import ConfigError, UsageError
from homebot.gateways import GatewayContext, HostService
from homebot.house import SimulatedHouse, World
from homebot.house.network import HouseNetwork
from homebot.runtime.plan import Plan

__all__ = ["HouseOfRun"]


@final
class HouseOfRun:
    """A simulated house, with the networks and the broker of its devices.

    Args:
        world: The house as it is described.
        configured: The names of the gateways in the configuration.
    """

    def __init__(self, world: World, configured: Collection[str]) -> None:
        self._world = world
        self._configured = frozenset(configured)
        self._network = HouseNetwork(world.families())

    def gateways(self) -> dict[str, dict[str, object]]:
        """Return the tables of the gateways that find its devices, see :meth:`HouseNetwork.gateways`."""
        return self._network.gateways()

    def running(self, random: Random | None) -> AbstractAsyncContextManager[tuple[object, ...]]:
        """Run its networks, see :meth:`HouseNetwork.running`."""
        return self._network.running(random)

    def check_host(self, needed: Iterable[HostService[object]], source: str) -> None:
        """Check that there is an embedded broker for its devices.

        Raises:
            ConfigError: No in-process peer of this name exists.
        """
        if all(service.kind is not SimulatedHouse.Host for service in needed):
            raise ConfigError(source, "gateways", SimulatedHouse.WITHOUT_HOST)

    def may_meet_real_devices(self, plan: Plan) -> bool:
        """Return whether a gateway of the configuration may find devices outside the house."""
        return any(
            one.name in self._configured
            and all(service.kind is not SimulatedHouse.Host for service in one.kind.host_services(one.settings))
            for one in plan.gateways
        )

    async def serve(
        self,
        context: GatewayContext,
        home: str,
        clock: Clock,
        *,
        task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
    ) -> None:
        """Run the devices at the host in *context* until cancelled.

        Args:
            home: The first level of their topics.

        Raises:
            UsageError: There is no host.
        """
        host = context.service(SimulatedHouse.Host)
        if host is None:
            raise UsageError(SimulatedHouse.WITHOUT_HOST)
        house = SimulatedHouse.hosted_by(host, home, self._world, clock, random=context.random, network=self._network)
        await house.serve(task_status=task_status)
