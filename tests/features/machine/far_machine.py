"""A machine in the attic whose gateway is one in memory, and the link of the machine with the index to it."""

from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager, suppress
from functools import partial
from pathlib import Path

import anyio
from anyio.abc import TaskGroup, TaskStatus
from pydantic import SecretStr
from tests.hanging_link import HangingLink
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import house_rights, robot_rights

from homebot.bridges.zenoh.current_session import CurrentSession
from homebot.bridges.zenoh.session import ZenohSession, open_session
from homebot.clock import LoopClock
from homebot.errors import LinkError
from homebot.features.machine.exports import serve_gateways
from homebot.features.machine.gateway import MachineGateway, MachineGatewaySettings
from homebot.features.machine.messages import GetGateways, GetGatewaysRequest, machine_name
from homebot.features.machine.wire import MachineWire
from homebot.gateways import GatewayContext
from homebot.gateways.memory import MemoryGateway
from homebot.graph import Graph, Node
from homebot.messages.interfaces.settings import RosSettings

NONE: Mapping[str, object] = {}
SECRET = "a secret of both machines"


class FarMachine:
    """The machine, which can lose its link; use :func:`far_machine`.

    Attributes:
        gateway: Its gateway, which goes on without the link.
        link: The link of the machine with the index, which is the router.
        wire: What joins the two, which can hang.
    """

    def __init__(self, gateway: MemoryGateway, link: CurrentSession, wire: HangingLink, tasks: TaskGroup) -> None:
        self.gateway = gateway
        self.link, self.wire, self._tasks = link, wire, tasks
        self._settings = RosSettings.model_validate({"connect": (wire.address,)})
        self._on_wire, self._lost = anyio.CancelScope(), anyio.Event()

    def near(
        self,
        node: Node,
        folder: Path,
        settings: Mapping[str, object] = NONE,
        *,
        secret: str = SECRET,
        home: str = "villa",
    ) -> MachineGateway:
        """Return the gateway of the machine with the index to it."""
        token = folder / "attic.token"
        token.touch(mode=0o600)
        token.write_text(f"{secret}\n")
        given = MachineGatewaySettings.model_validate({"machine": "attic", "token_file": token, **settings})
        return MachineGateway(node, given, GatewayContext.of(self.link, home=home))

    async def lose_link(self) -> None:
        """Take it off the wire."""
        self._on_wire.cancel()
        await self._lost.wait()

    async def mend_link(self, gateways: tuple[str, ...] = ("memory",)) -> None:
        """Put it on the wire, with these *gateways*."""
        self._on_wire, self._lost = anyio.CancelScope(), anyio.Event()
        await self._tasks.start(partial(self._serve, gateways))

    async def copy(self) -> None:
        """Run a second machine with the same configuration."""
        self._on_wire = anyio.CancelScope()
        await self._tasks.start(partial(self._serve, ("memory",), Graph()))

    async def _serve(
        self, gateways: tuple[str, ...], graph: Graph | None = None, *, task_status: TaskStatus[None]
    ) -> None:
        with self._on_wire:
            async with (
                open_session(self._settings, robot_rights(self._settings, "attic")) as session,
                Node(graph or self.gateway.node.graph, "machine") as node,
            ):
                node.create_task(session.run)
                wire = MachineWire(node, session, SecretStr(SECRET))
                await serve_gateways(node, wire, "villa", "attic", gateways, task_status=task_status)
        self._lost.set()


@asynccontextmanager
async def far_machine(epoch: float | None = None) -> AsyncIterator[FarMachine]:
    """Run the machine, and the router of the other one, inside the block.

    Args:
        epoch: The time of day there at the start, in seconds since 1970; by default the right one.
    """
    port = reserve_port()
    settings = RosSettings.model_validate({"listen": f"tcp/127.0.0.1:{port}"})
    async with (
        HangingLink(port).running() as wire,
        open_session(settings, house_rights(settings, "attic")) as session,
        Node(Graph(LoopClock(epoch)), "memory", namespace="/gateway") as node,
        anyio.create_task_group() as tasks,
    ):
        gateway, link = MemoryGateway(node), CurrentSession()
        await tasks.start(gateway.serve)
        tasks.start_soon(session.run)
        link.session = session
        machine = FarMachine(gateway, link, wire, tasks)
        await machine.mend_link()
        await _reached(session)
        yield machine
        tasks.cancel_scope.cancel()


async def _reached(session: ZenohSession) -> None:
    """Wait until the machine answers: the router hears of its services a moment after they are offered."""
    async with Node(Graph(), "probe") as node:
        wire = MachineWire(node, session, SecretStr(SECRET))
        with anyio.fail_after(PATIENCE):
            while True:
                with suppress(LinkError):
                    await wire.ask(machine_name("villa", "attic", "gateways"), GetGateways, GetGatewaysRequest(), 1.0)
                    break
        wire.close()
