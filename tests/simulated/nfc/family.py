"""The family of simulated NFC tags."""

import socket
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from random import Random

from tests.simulated.nfc.field import TagField

from homebot.house.family import LOOPBACK, FamilyNetwork, ServedFamily, free_port


class NfcNetwork(FamilyNetwork):
    """The field of a reader."""

    def __init__(self) -> None:
        super().__init__()
        self._port = free_port(socket.SOCK_DGRAM)

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table with the reader's address."""
        return {"nfc": {"devices": [f"udp:{LOOPBACK}:{self._port}"]}}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the field."""
        del random
        tags = TagField(self._port)
        self.options["field"] = tags
        async with tags.served():
            yield ()


class TagFamily(ServedFamily):
    """Tags that are held into the field."""

    kinds = frozenset({"tag"})
    device = "tests.simulated.nfc.field:ServedTag"
    network = NfcNetwork
