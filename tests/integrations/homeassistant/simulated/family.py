"""The family of simulated devices that are entities of a simulated Home Assistant."""

import os
import secrets
import socket
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from random import Random

import anyio

from homebot.house.family import ALL_KINDS, LOOPBACK, FamilyNetwork, ServedFamily, free_port

TOKEN = "HOMEBOT_SIMULATED_TOKEN"
"""Environment variable with the token of the simulated Home Assistant."""


class HomeAssistantNetwork(FamilyNetwork):
    """A Home Assistant with the devices of the house."""

    def __init__(self) -> None:
        super().__init__()
        self._port = free_port(socket.SOCK_STREAM)

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table with the server's address."""
        os.environ.setdefault(TOKEN, secrets.token_hex(16))
        return {"homeassistant": {"url": f"http://{LOOPBACK}:{self._port}", "token_env": TOKEN}}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the server."""
        del random
        from tests.integrations.homeassistant.simulated.server import SimulatedHomeAssistant  # noqa: PLC0415 - an extra

        home = SimulatedHomeAssistant(LOOPBACK, self._port)
        home.token = os.environ.setdefault(TOKEN, home.token)
        self.options["server"] = home
        async with anyio.create_task_group() as tasks:
            await tasks.start(home.serve)
            yield ()
            tasks.cancel_scope.cancel()


class HomeAssistantFamily(ServedFamily):
    """Entities."""

    kinds = ALL_KINDS
    device = "tests.integrations.homeassistant.simulated.entity:ServedEntity"
    network = HomeAssistantNetwork
