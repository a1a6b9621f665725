"""The mDNS gateway keeps the contract, with a lamp that zeroconf announces on loopback, and a driver of the test's."""

import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
from tests.gateways.mdns.lamp import DRIVER, LOOPBACK, SERVICE_TYPE, LampServer, Publisher, publisher
from tests.gateways.mdns.packets import answer, pointer

from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.mdns import MdnsGateway, MdnsGatewaySettings, NetworkInterfaces
from homebot.gateways.mdns.network import Interfaces
from homebot.graph import Node
from homebot.testing.gateway_contract import GatewayContract, Lamp


class Cable(NetworkInterfaces):
    """The interface to the network of the test, with a cable that can be pulled."""

    def __init__(self) -> None:
        self._is_in = True
        self._moved = anyio.Event()

    def find(self, wanted: tuple[str, ...]) -> Interfaces:
        return super().find(wanted) if self._is_in else ()

    async def wait_for_change(self, wanted: tuple[str, ...], before: Interfaces) -> Interfaces:
        while (now := self.find(wanted)) == before:
            await self._moved.wait()
        return now

    def move(self, *, is_in: bool) -> None:
        self._is_in = is_in
        self._moved.set()
        self._moved = anyio.Event()


class MdnsLamp(Lamp):
    """A lamp on loopback."""

    def __init__(self, server: LampServer, computer: Publisher) -> None:
        super().__init__(f"Hall.{SERVICE_TYPE}", address="lamp/hall")
        self.server = server
        self.computer = computer
        self.cable = Cable()

    async def announce(self) -> None:
        await self.computer.announce("Hall", self.server.port)

    async def report(self, *, on: bool) -> None:
        await self.server.switch(on=on)

    def raw(self, *, on: bool) -> bytes:
        return b"state on" if on else b"state off"

    async def misbehave(self) -> None:
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
            stranger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(LOOPBACK))
            for start in range(0, 3000, 20):
                names = [f"stranger {number}.{SERVICE_TYPE}" for number in range(start, start + 20)]
                stranger.sendto(answer(*(pointer(SERVICE_TYPE, name) for name in names)), ("224.0.0.251", 5353))
                await anyio.sleep(0.001)

    async def withdraw(self) -> None:
        await self.computer.withdraw("Hall")

    async def told(self) -> bool | None:
        return self.server.told[-1] == "on" if self.server.told else None

    async def lose_link(self) -> None:
        self.cable.move(is_in=False)

    async def mend_link(self) -> None:
        self.cable.move(is_in=True)


class TestMdnsGateway(GatewayContract):
    """One lamp."""

    name = "mdns"

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        server = LampServer()
        async with publisher() as computer, server.listening():
            yield MdnsLamp(server, computer)

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, MdnsLamp)
        table = {
            "interfaces": [LOOPBACK],
            "service_types": [SERVICE_TYPE],
            "announce": False,
            "drivers": {DRIVER: {"raw_address": lamp.address}},
            **settings,
        }
        context = GatewayContext(services={NetworkInterfaces: lamp.cable})
        return MdnsGateway(node, MdnsGatewaySettings.model_validate(table), context)
