"""The family of simulated HomeKit accessories."""

import importlib
import secrets
import tempfile
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from random import Random
from typing import TYPE_CHECKING

import anyio
from anyio import to_thread

from homebot.house.family import ALL_KINDS, LOOPBACK, LoopbackMdns, ServedFamily

if TYPE_CHECKING:
    from tests.integrations.homekit.simulated.bridge import SimulatedHomekitBridge

_BRIDGE = "tests.integrations.homekit.simulated.bridge"


class HomekitNetwork(LoopbackMdns):
    """A bridge with the accessories of the house, paired with homebot."""

    def __init__(self) -> None:
        super().__init__()
        self._pairings = Path(tempfile.gettempdir()) / f"homebot-{secrets.token_hex(8)}.pairings.json"

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table with the pairings, and that of the gateway that finds the accessories."""
        return {"homekit": {"pairings": str(self._pairings)}, **super().gateways()}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the bridge."""
        del random
        module = await to_thread.run_sync(importlib.import_module, _BRIDGE)  # reads files
        bridge: SimulatedHomekitBridge = module.SimulatedHomekitBridge(LOOPBACK, self._pairings)
        self.options["bridge"] = bridge
        async with anyio.create_task_group() as tasks:
            await tasks.start(bridge.serve)
            yield ()
            tasks.cancel_scope.cancel()


class HomekitFamily(ServedFamily):
    """Accessories."""

    kinds = ALL_KINDS - {"power_meter"}
    device = f"{_BRIDGE}:ServedAccessory"
    network = HomekitNetwork
