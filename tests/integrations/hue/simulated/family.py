"""The family of simulated devices behind a Philips Hue bridge."""

import secrets
import socket
import tempfile
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from random import Random

from homebot.house.family import LOOPBACK, FamilyNetwork, ServedFamily, free_port


class HueNetwork(FamilyNetwork):
    """A bridge that is paired with homebot."""

    def __init__(self) -> None:
        super().__init__()
        self._port = free_port(socket.SOCK_STREAM)
        self._pairings = Path(tempfile.gettempdir()) / f"homebot-{secrets.token_hex(8)}.pairings.hue"

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table with the pairing."""
        return {"hue": {"pairings": str(self._pairings)}}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the bridge."""
        del random
        from tests.integrations.hue.simulated.bridge import paired_bridge  # noqa: PLC0415 - an extra

        async with paired_bridge(LOOPBACK, self._port, self._pairings) as bridge:
            self.options["bridge"] = bridge
            yield ()


class HueFamily(ServedFamily):
    """Lamps and sensors."""

    kinds = frozenset({"contact", "lamp", "lux", "motion"})
    device = "tests.integrations.hue.simulated.bridge:HueHouseDevice"
    network = HueNetwork
