"""A house and a robot: two graphs joined by Zenoh on this computer."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial

import anyio
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import house_rights, robot_rights

from homebot.bridges.rosbridge.access import ClientAccess
from homebot.bridges.zenoh.session import open_session
from homebot.devices.client_rights import ALL_RIGHTS
from homebot.devices.robot_owners import RobotOwners
from homebot.features.ros2.link import serve_link
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import Graph, Node
from homebot.messages.interfaces.settings import RosSettings
from homebot.words.rights import read_scope

OWNERS = RobotOwners({"rosie": ()})


class Pair:
    """A house and a robot."""

    def __init__(self, house: Graph) -> None:
        self.house, self.robot = house, Graph()
        self._robot = anyio.CancelScope()

    def leave(self) -> None:
        """Let the robot go."""
        self._robot.cancel()

    async def run_robot(
        self, settings: RosSettings, robots: RobotsOnWire, *, task_status: anyio.abc.TaskStatus[None]
    ) -> None:
        with self._robot:
            await linked(self.robot, "brain", "/rosie", settings, robots, task_status=task_status)


def access(name: str, *scope: str) -> ClientAccess:
    return ClientAccess(name, read_scope(scope) if scope else ALL_RIGHTS, OWNERS)


@asynccontextmanager
async def pair(
    *scope: str, export: str = "/house/**", robots: str = "/**", house: Graph | None = None
) -> AsyncIterator[Pair]:
    """The robot sees all that the house exports; what it has comes to the house with the rights of *scope*."""
    both, address = Pair(house or Graph()), f"tcp/127.0.0.1:{reserve_port()}"
    at_house = RosSettings.model_validate({"listen": address, "export": (export,), "import": {"rosie": (robots,)}})
    at_robot = RosSettings.model_validate(
        {"connect": (address,), "export": ("/rosie/**", "/free/**"), "import": {"h": ("/**",)}}
    )
    robots_there = RobotsOnWire(at_house.imports, {"rosie": access("rosie", *scope)})
    houses = RobotsOnWire(at_robot.imports, {"h": access("h")})
    async with anyio.create_task_group() as tasks:
        await tasks.start(partial(linked, both.house, "ros2", "/", at_house, robots_there))
        await tasks.start(partial(both.run_robot, at_robot, houses))
        yield both
        tasks.cancel_scope.cancel()


async def linked(
    graph: Graph,
    name: str,
    namespace: str,
    settings: RosSettings,
    robots: RobotsOnWire,
    *,
    task_status: anyio.abc.TaskStatus[None],
) -> None:
    rights = house_rights(settings) if settings.listen else robot_rights(settings, "rosie")
    async with open_session(settings, rights) as session, Node(graph, name, namespace=namespace) as node:
        node.create_task(session.run)
        await serve_link(node, session, settings, robots, task_status=task_status)


async def appears(graph: Graph, name: str) -> None:
    """Wait until *graph* has the topic or service *name*."""
    with graph.watch() as changes, anyio.fail_after(PATIENCE):
        if not any(one.name == name for one in graph.get_endpoints()):
            async for change in changes:
                if change.entity.name == name:
                    return
