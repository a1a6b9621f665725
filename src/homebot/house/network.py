"""The networks of a simulated house besides its broker. The house tells which gateways its devices need."""

from __future__ import annotations

import importlib
from collections.abc import AsyncIterator, Callable, Iterable
from contextlib import AsyncExitStack, asynccontextmanager
from random import Random
from typing import TypeAlias

from homebot.house.connected_device import ConnectedDevice
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.family import family_of

OnCommand: TypeAlias = Callable[[str], None]


class HouseNetwork:
    """The networks of one house.

    Args:
        families: The families of its devices.
    """

    def __init__(self, families: Iterable[str]) -> None:
        named = ((name, family_of(name)) for name in families)
        self._served = {name: family for name, family in named if isinstance(family, type)}
        kinds = dict.fromkeys(served.network for served in self._served.values())
        self._networks = {kind: kind() for kind in kinds}

    @asynccontextmanager
    async def running(self, random: Random | None) -> AsyncIterator[tuple[object, ...]]:
        """Run the networks inside the block; yield the services that gateways need.

        Args:
            random: The source of random numbers; None for one of its own.
        """
        needed: tuple[object, ...] = ()
        async with AsyncExitStack() as stack:
            for network in self._networks.values():
                needed += await stack.enter_async_context(network.running(random or Random()))  # noqa: S311 - no secret
            yield needed

    def gateways(self) -> dict[str, dict[str, object]]:
        """Return the tables of the gateways that find its devices, by the names of their plug-ins."""
        return {
            gateway: dict(table) for network in self._networks.values() for gateway, table in network.gateways().items()
        }

    def connect(
        self, family: str, device: SimulatedDeviceInfo, on_command: OnCommand, **options: object
    ) -> ConnectedDevice:
        """Return a device of a served family, online while it lives; called inside :meth:`running`.

        Args:
            options: Further arguments of the class of the device.
        """
        spec = self._served[family]
        module, _, name = spec.device.partition(":")
        make: Callable[..., ConnectedDevice] = getattr(importlib.import_module(module), name)
        return make(device, on_command, **{**spec.options, **self._networks[spec.network].options, **options})
