"""The families of simulated Matter nodes, and of devices behind a bridge, which share one server."""

import socket
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from random import Random
from types import MappingProxyType

import anyio

from homebot.house.family import ALL_KINDS, LOOPBACK, FamilyNetwork, ServedFamily, free_port


class MatterNetwork(FamilyNetwork):
    """A Matter server with the nodes that it has commissioned."""

    def __init__(self) -> None:
        super().__init__()
        self._port = free_port(socket.SOCK_STREAM)

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table with the server's address."""
        return {"matter": {"url": f"ws://{LOOPBACK}:{self._port}/ws"}}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the server."""
        del random
        from tests.integrations.matter.simulated.server import SimulatedMatterServer  # noqa: PLC0415 - an extra

        server = SimulatedMatterServer(LOOPBACK, self._port)
        self.options["server"] = server
        async with anyio.create_task_group() as tasks:
            await tasks.start(server.serve)
            yield ()
            tasks.cancel_scope.cancel()


class MatterFamily(ServedFamily):
    """Nodes of their own."""

    kinds = ALL_KINDS
    device = "tests.integrations.matter.simulated.node:ServedMatterNode"
    network = MatterNetwork


class MatterPlugFamily(MatterFamily):
    """Lamps at a plug."""

    kinds = frozenset({"lamp"})
    options = MappingProxyType({"kind": "plug"})


class BridgedMatterFamily(MatterFamily):
    """Devices behind a bridge."""

    device = "tests.integrations.matter.simulated.node:BridgedMatterDevice"
