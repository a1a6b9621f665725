"""A gateway of another machine keeps the contract, with the gateway in memory on the other side, over Zenoh."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager
from pathlib import Path
from typing import ClassVar

import anyio
import pytest
from anyio.abc import TaskGroup, TaskStatus
from pydantic import SecretStr
from tests.gateways.test_contract_memory import MemoryLamp
from tests.ports import reserve_port

from homebot.bridges.machines.exports import serve_gateways
from homebot.bridges.machines.on_wire import MachinesOnWire
from homebot.bridges.machines.wire import MachineWire
from homebot.bridges.ros2.session import open_session
from homebot.devices.value import PlainValue
from homebot.gateways import Gateway, GatewayContext
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from homebot.integrations.machines.gateway import MachineGateway, MachineGatewaySettings
from homebot.messages.interfaces.settings import RosSettings
from homebot.testing.gateway_contract import GatewayContract, Lamp

pytestmark = pytest.mark.slow

SECRET = "a secret of both machines"


class FarLamp(Lamp):
    """A lamp of a machine in the attic, with a gateway in memory.

    Attributes:
        link: The link of the machine with the index, which is the router.
    """

    settings: ClassVar[Mapping[str, PlainValue]] = MemoryLamp.settings

    def __init__(self, there: MemoryLamp, link: MachinesOnWire, router: str, tasks: TaskGroup) -> None:
        super().__init__(there.key, address=there.address)
        self.link = link
        self._there, self._tasks = there, tasks
        self._settings = RosSettings.model_validate({"connect": (router,)})
        self._link, self._lost = anyio.CancelScope(), anyio.Event()

    async def announce(self) -> None:
        await self._there.announce()

    async def report(self, *, on: bool) -> None:
        await self._there.report(on=on)

    def raw(self, *, on: bool) -> bytes:
        return self._there.raw(on=on)

    async def misbehave(self) -> None:
        await self._there.misbehave()

    async def withdraw(self) -> None:
        await self._there.withdraw()

    async def told(self) -> bool | None:
        return await self._there.told()

    async def told_value(self, capability: str) -> PlainValue:
        return await self._there.told_value(capability)

    async def lose_link(self) -> None:
        self._link.cancel()
        await self._lost.wait()

    async def mend_link(self) -> None:
        self._link, self._lost = anyio.CancelScope(), anyio.Event()
        await self._tasks.start(self.serve)

    async def serve(self, *, task_status: TaskStatus[None]) -> None:
        """Let the machine be on the wire until it loses its link."""
        graph = self._there.gateway.node.graph
        with self._link:
            async with open_session(self._settings) as session, Node(graph, "machine") as node:
                node.create_task(session.run)
                wire = MachineWire(node, session, SecretStr(SECRET))
                await serve_gateways(node, wire, "villa", "attic", ("memory",), task_status=task_status)
        self._lost.set()


class TestMachineGateway(GatewayContract):
    """One lamp."""

    @pytest.fixture(autouse=True)
    def _secret(self, tmp_path: Path) -> None:
        self._token = tmp_path / "attic.token"
        self._token.touch(mode=0o600)
        self._token.write_text(f"{SECRET}\n")

    @asynccontextmanager
    async def lamp(self) -> AsyncIterator[Lamp]:
        router = f"tcp/127.0.0.1:{reserve_port()}"
        there = MemoryLamp("hall", address="memory/hall")
        async with (
            open_session(RosSettings.model_validate({"listen": router})) as session,
            Node(Graph(), "memory", namespace="/gateway") as node,
            anyio.create_task_group() as tasks,
        ):
            there.gateway = MemoryGateway(node)
            await tasks.start(there.gateway.serve)
            tasks.start_soon(session.run)
            link = MachinesOnWire()
            link.session = session
            lamp = FarLamp(there, link, router, tasks)
            await tasks.start(lamp.serve)
            yield lamp
            tasks.cancel_scope.cancel()

    def gateway(self, lamp: Lamp, node: Node, settings: dict[str, object]) -> Gateway:
        assert isinstance(lamp, FarLamp)
        given = {"machine": "attic", "token_file": self._token, **settings}
        context = GatewayContext.of(lamp.link, home="villa")
        return MachineGateway(node, MachineGatewaySettings.model_validate(given), context)
