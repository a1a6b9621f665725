"""The family of simulated CoAP devices, which register in a resource directory."""

import socket
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from random import Random

from homebot.house.family import LOOPBACK, FamilyNetwork, ServedFamily, free_port


class CoapNetwork(FamilyNetwork):
    """A resource directory."""

    def __init__(self) -> None:
        super().__init__()
        self._port = free_port(socket.SOCK_DGRAM)
        self.options["directory"] = f"coap://{LOOPBACK}:{self._port}"

    def gateways(self) -> Mapping[str, Mapping[str, object]]:
        """Return the table of a gateway that looks devices up there."""
        return {"coap": {"resource_directory": [self.options["directory"]]}}

    @asynccontextmanager
    async def running(self, random: Random) -> AsyncIterator[tuple[object, ...]]:
        """Run the directory."""
        del random
        from tests.simulated.coap_directory import served_directory  # noqa: PLC0415 - an extra

        async with served_directory(LOOPBACK, self._port):
            yield ()


class CoapFamily(ServedFamily):
    """Lamps with a Thing Description, and sensors with resources of IPSO."""

    kinds = frozenset({"lamp", "lux", "motion", "thermostat"})
    device = "tests.simulated.coap_devices:CoapDevice"
    network = CoapNetwork
