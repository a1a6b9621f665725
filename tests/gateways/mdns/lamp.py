"""A lamp on the network: a real server of a line protocol, announced by zeroconf on loopback, and its driver.

The protocol is ``on``, ``off`` and ``state`` to the lamp, and ``state on`` and the like from it.
"""

import os
from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from typing import ClassVar

import anyio
from anyio.abc import SocketAttribute, SocketStream
from anyio.streams.buffered import BufferedByteReceiveStream
from zeroconf import IPVersion, ServiceInfo
from zeroconf.asyncio import AsyncZeroconf

from homebot.devices.gateway_messages import Command
from homebot.errors import LinkError, RefusedError
from homebot.gateways.announced.gateway_device import GatewayDevice, simple_part
from homebot.gateways.drivers import Driver, DriverSettings

LOOPBACK = "127.0.0.1"
SERVICE_TYPE = f"_hb{os.getpid()}._tcp.local."
"""Another for each process: those that run at the same time hear each other."""

HOST = f"hall-{os.getpid()}.local."
"""Likewise: what one says of a computer of this name is in the cache of all."""

DRIVER = f"{__name__}:LampDriver"


class Publisher:
    """A computer that announces services on loopback; entered, it is on the network."""

    def __init__(self) -> None:
        self._zeroconf = AsyncZeroconf(interfaces=[LOOPBACK], ip_version=IPVersion.V4Only)
        self._services: dict[str, ServiceInfo] = {}

    async def announce(
        self,
        name: str,
        port: int,
        properties: Mapping[str, str | bytes] | bytes | None = None,
        *,
        service_type: str = SERVICE_TYPE,
        host: str = HOST,
        ttl: int = 120,
    ) -> str:
        """Announce a service, or another description of it; return its full name."""
        full = f"{name}.{service_type}"
        said = properties if isinstance(properties, bytes) else dict(properties or {})
        info = ServiceInfo(
            service_type, full, port, properties=said, server=host, host_ttl=ttl, parsed_addresses=[LOOPBACK]
        )
        if full in self._services:
            sent = await self._zeroconf.async_update_service(info)
        else:
            sent = await self._zeroconf.async_register_service(info, cooperating_responders=True)
        self._services[full] = info
        await sent
        return full

    async def withdraw(self, name: str, service_type: str = SERVICE_TYPE) -> None:
        """Say goodbye for a service."""
        info = self._services.pop(f"{name}.{service_type}", None)
        if info is not None:
            await (await self._zeroconf.async_unregister_service(info))

    async def vanish(self) -> None:
        """Be gone without a word, with all services, as in a power failure."""
        for info in self._services.values():
            self._zeroconf.zeroconf.registry.async_remove(info)
        self._services.clear()

    async def close(self) -> None:
        """Say goodbye for all, and leave."""
        await self._zeroconf.async_close()


@asynccontextmanager
async def publisher() -> AsyncIterator[Publisher]:
    """A computer that is on the network inside the block."""
    computer = Publisher()
    try:
        yield computer
    finally:
        with anyio.CancelScope(shield=True):
            await computer.close()


class LampServer:
    """The lamp itself, a TCP server.

    Attributes:
        port: Where it listens.
        told: What it was told, oldest first.
        connections: How often somebody connected.
        greeting: What it says first.
    """

    def __init__(self) -> None:
        self.port = 0
        self.is_on = False
        self.told: list[str] = []
        self.connections = 0
        self.greeting = b""
        self._clients: set[SocketStream] = set()

    @asynccontextmanager
    async def listening(self, port: int = 0) -> AsyncIterator[None]:
        """Have power inside the block."""
        listener = await anyio.create_tcp_listener(local_host=LOOPBACK, local_port=port)
        self.port = listener.extra(SocketAttribute.local_port)  # noqa: S610 - not Django's
        async with listener, anyio.create_task_group() as tasks:
            tasks.start_soon(listener.serve, self._serve)
            yield
            tasks.cancel_scope.cancel()

    async def switch(self, *, on: bool) -> None:
        """Be switched on the spot."""
        self.is_on = on
        for client in tuple(self._clients):
            await client.send(self.line())

    async def say(self, text: bytes) -> None:
        """Say something to everybody."""
        for client in tuple(self._clients):
            await client.send(text)

    def line(self) -> bytes:
        return b"state on\n" if self.is_on else b"state off\n"

    async def hang_up(self) -> None:
        """Close all connections."""
        for client in tuple(self._clients):
            await client.aclose()

    async def _serve(self, stream: SocketStream) -> None:
        self.connections += 1
        self._clients.add(stream)
        lines = BufferedByteReceiveStream(stream)
        try:
            async with stream:
                if self.greeting:
                    await stream.send(self.greeting)
                while True:
                    told = (await lines.receive_until(b"\n", 100)).decode()
                    if told != "state":
                        self.told.append(told)
                        self.is_on = told == "on"
                    await stream.send(self.line())
        except (anyio.EndOfStream, anyio.IncompleteRead, anyio.BrokenResourceError, anyio.ClosedResourceError):
            return
        finally:
            self._clients.discard(stream)


class LampSettings(DriverSettings):
    """The table of the driver."""

    raw_address: str = "lamp/raw"


class LampDriver(Driver):
    """The driver of such lamps."""

    service_types: ClassVar[frozenset[str]] = frozenset({SERVICE_TYPE})
    Settings: ClassVar[type[DriverSettings]] = LampSettings
    stream: SocketStream

    async def run(self) -> None:
        assert isinstance(self.settings, LampSettings)
        try:
            self.stream = await anyio.connect_tcp(self.service.addresses[0], self.service.port)
        except OSError as exc:
            raise LinkError(f"{self.service.name} cannot be reached") from exc
        part = simple_part("light", settable=("on_off",))
        async with self.stream:
            try:
                await self.stream.send(b"state\n")
                lines = BufferedByteReceiveStream(self.stream)
                first = await lines.receive_until(b"\n", 100)
                if first == b"password?":
                    raise RefusedError("the connection", "give a password")
                self.host.describe(
                    GatewayDevice(
                        self.service.key,
                        self.service.name,
                        (part,),
                        metadata={"model": "Lamp 1"},
                        raw_address=self.settings.raw_address,
                    )
                )
                await self._take(first)
                while True:
                    await self._take(await lines.receive_until(b"\n", 100))
            except (OSError, anyio.BrokenResourceError, anyio.EndOfStream, anyio.IncompleteRead) as exc:
                raise LinkError("the connection was lost") from exc

    async def _take(self, line: bytes) -> None:
        if line not in {b"state on", b"state off"}:
            self.host.reject(line, "is no state")
            return
        await self.host.deliver_raw(line)
        await self.host.report({"on_off": line == b"state on"})

    async def perform(self, command: Command) -> None:
        try:
            await self.stream.send(b"on\n" if command.value.plain() else b"off\n")
        except (anyio.BrokenResourceError, anyio.ClosedResourceError) as exc:
            raise LinkError("the connection was lost") from exc
