"""The gateway for CoAP keeps the contract: a lamp in a resource directory, both on aiocoap and loopback."""

import asyncio
from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import asynccontextmanager
from typing import ClassVar

import aiocoap
import anyio
import pytest
from aiocoap import resource
from aiocoap.cli.rd import StandaloneResourceDirectory
from anyio.abc import TaskGroup, TaskStatus
from tests.gateways.lamp_orders import INFO, OrderedLamp, is_told_on
from tests.ports import reserve_datagram_port
from tests.simulated.coap_devices import CoapDevice

from homebot.devices.value import PlainValue
from homebot.gateways import Gateway
from homebot.gateways.coap import CoapGateway, CoapGatewaySettings
from homebot.graph import Node
from homebot.house.dialect import DeviceState
from homebot.testing.gateway_contract import GatewayContract, Lamp

pytestmark = pytest.mark.rooms("things")

OLD = 75.0
"""Seconds after which the last state is too old, and the list is read again: Max-Age is a minute where none is told."""


async def serve(port: int, site: resource.Site | None, *, task_status: TaskStatus[None]) -> None:
    """Run a CoAP server until cancelled, without a site aiocoap's resource directory."""
    context = await aiocoap.Context.create_server_context(site, bind=("127.0.0.1", port), transports=["udp6"])
    context.serversite = site or StandaloneResourceDirectory(context)
    task_status.started()
    try:
        await anyio.sleep_forever()
    finally:
        with anyio.CancelScope(shield=True):
            await context.shutdown()
            # The directory leaves the lifetimes of its registrations behind.
            for task in [one for one in asyncio.all_tasks() if one.get_name().startswith("RD Timeout")]:
                task.cancel()
                await asyncio.wait([task])


class Background:
    """Tasks that can be started and ended at any time inside one task group."""

    def __init__(self, tasks: TaskGroup) -> None:
        self._tasks = tasks
        self._running: list[tuple[anyio.CancelScope, anyio.Event]] = []

    async def start(self, function: Callable[..., Awaitable[object]], *arguments: object) -> None:
        scope, ended = anyio.CancelScope(), anyio.Event()
        self._running.append((scope, ended))

        async def run(*, task_status: TaskStatus[None]) -> None:
            with scope:
                await function(*arguments, task_status=task_status)
            ended.set()

        await self._tasks.start(run)

    async def end(self) -> None:
        for scope, ended in self._running:
            scope.cancel()
            await ended.wait()
        self._running.clear()


class CoapLamp(OrderedLamp):
    """A simulated lamp that registers itself."""

    settings: ClassVar[Mapping[str, PlainValue]] = {"level": 40.0}
    device: CoapDevice

    def __init__(self, directory_port: int, world: Background) -> None:
        self.world = world
        self.directory = f"coap://127.0.0.1:{directory_port}"
        self.directory_port = directory_port
        self.device = CoapDevice(INFO, self.obey, directory=self.directory)
        self.device.begin(DeviceState(text="off"), has_power=True)
        super().__init__("Hall", address=self.device.uri)
        self.is_there = False

    def obey(self, order: str) -> None:
        super().obey(order)
        is_on = is_told_on(self.orders) is True
        self.device.publish(DeviceState(text="on" if is_on else "off", is_on=is_on))

    async def announce(self) -> None:
        self.is_there = True
        await self._start_device()

    async def _start_device(self) -> None:
        await self.world.start(self._live)

    async def _live(self, *, task_status: TaskStatus[None]) -> None:
        task_status.started()
        await self.device.live()

    async def misbehave(self) -> None:
        """Let another endpoint register, and send what is no state as fast as it can."""

        class Stranger(resource.ObservableResource):  # type: ignore[misc]  # the library has no types
            ct = "50"

            async def render_get(self, request: aiocoap.Message) -> aiocoap.Message:
                del request
                return aiocoap.Message(payload=b"{" + b"?" * 900, content_format=50)

        site, strangers, port = resource.Site(), [Stranger() for _ in range(20)], reserve_datagram_port()
        site.add_resource([".well-known", "core"], resource.WKCResource(site.get_resources_as_linkheader))
        for number, stranger in enumerate(strangers):
            site.add_resource(["3303", f"{number}", "5700"], stranger)
        await self.world.start(serve, port, site)
        context = await aiocoap.Context.create_client_context(transports=["udp6"])
        message = aiocoap.Message(
            code=aiocoap.POST, uri=f"{self.directory}/resourcedirectory/?ep=stranger&base=coap://127.0.0.1:{port}"
        )
        message.opt.content_format = 40
        await context.request(message).response
        await context.shutdown()

        async def send(*, task_status: TaskStatus[None]) -> None:
            task_status.started()
            while True:
                for stranger in strangers:
                    stranger.updated_state()
                await anyio.sleep(0.002)

        await self.world.start(send)

    async def withdraw(self) -> None:
        await self.device.deregister()

    async def lose_link(self) -> None:
        await self.world.end()
        loop = asyncio.get_running_loop()
        now = loop.time
        loop.time = lambda: now() + OLD  # type: ignore[method-assign]

    async def mend_link(self) -> None:
        self.device._registration = ""
        await self.world.start(serve, self.directory_port, None)
        if self.is_there:
            await self._start_device()


class TestCoapGateway(GatewayContract):
    """One lamp."""

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        async with anyio.create_task_group() as tasks:
            lamp = CoapLamp(reserve_datagram_port(), Background(tasks))
            await lamp.mend_link()
            yield lamp
            await lamp.world.end()

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, CoapLamp)
        table = settings | {"resource_directory": [lamp.directory]}
        return CoapGateway(node, CoapGatewaySettings.model_validate(table))
