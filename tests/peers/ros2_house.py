"""A house with a link to ROS 2, and a robot that pyzeros is: another implementation of ROS 2 nodes on Zenoh."""

import json
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, nullcontext
from functools import partial
from typing import Any

import anyio
import pytest
import zenoh
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import HOME, house_rights, log_in

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.zenoh.rights import WireRights
from homebot.bridges.zenoh.session import open_session
from homebot.devices.robot_owners import RobotOwners
from homebot.features.ros2.link import serve_link
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import Graph, Node
from homebot.messages.interfaces.settings import RosSettings
from homebot.words.rights import read_scope

SCOPE = ("read", "act: harmless", "robot: rosie", "manage")
EXPORT = ("/house/**", "/map", "/app", "/app/*", "/parameter_events")


@asynccontextmanager
async def house(*, is_router: bool = True, scope: tuple[str, ...] = SCOPE) -> AsyncIterator[tuple[Node, int]]:
    """An app at the house, and the port to which a robot connects: at the house, or at a router of its own."""
    port = reserve_port()
    address = f"tcp/127.0.0.1:{port}"
    router = {"mode": "router", "listen": {"endpoints": [address]}, "scouting": {"multicast": {"enabled": False}}}
    async with anyio.create_task_group() as tasks, Node(Graph(), "app") as app:
        with nullcontext() if is_router else zenoh.open(zenoh.Config.from_json5(json.dumps(router))):
            link: dict[str, object] = {"listen": address} if is_router else {"connect": (address,)}
            await tasks.start(partial(_serve, app.graph, link, scope))
            yield app, port
            tasks.cancel_scope.cancel()


async def _serve(
    graph: Graph, link: dict[str, object], scope: tuple[str, ...], *, task_status: anyio.abc.TaskStatus[None]
) -> None:
    settings = RosSettings.model_validate({**link, "export": EXPORT, "import": {"rosie": ("/rosie/**",)}})
    rights = house_rights(settings) if settings.listen else WireRights.of_routers(settings, HOME, None)
    access = ClientAccess("rosie", read_scope(scope), RobotOwners({"rosie": ()}))
    async with open_session(settings, rights) as session, Node(graph, "ros2") as node:
        node.create_task(session.run)
        robots = RobotsOnWire(settings.imports, {"rosie": access})
        await serve_link(node, session, settings, robots, task_status=task_status)


def compile_messages(pyzeros: Any) -> None:
    """Compile what pyzeros needs in a first call, which takes 15 s, or minutes on a busy machine.

    For this it leaves an import hook that reads the working directory, in the event loop of whichever test comes next.
    """
    hooks = [*sys.meta_path]
    pyzeros.builtin_msgs.Attachment().serialize()
    sys.meta_path[:] = hooks


@asynccontextmanager
async def robot(port: int) -> AsyncIterator[Any]:
    """The Zenoh session of the node ``/rosie/brain`` of pyzeros."""
    pyzeros: Any = pytest.importorskip("pyzeros")
    compile_messages(pyzeros)
    afor: Any = pytest.importorskip("asyncio_for_robotics")
    with (
        log_in(f"tcp/127.0.0.1:{port}", "rosie", patience=PATIENCE) as session,
        pyzeros.auto_context(node="brain", namespace="/rosie", zenoh_session=session),
    ):
        async with afor.Scope():
            yield session
