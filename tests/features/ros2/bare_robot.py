"""A house, and a robot that is a bare session: it says and sends what no node would."""

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from functools import partial

import anyio
import anyio.lowlevel
from tests.features.ros2.pair import access, linked
from tests.patience import PATIENCE
from tests.ports import reserve_port
from tests.robots_on_wire import robot_rights

from homebot.bridges.zenoh.session import Declared, ZenohSession, open_session
from homebot.bridges.zenoh.tokens import EntityToken
from homebot.devices.health import GetHealth, HealthRequest, HealthResponse
from homebot.features.ros2.robots import RobotsOnWire
from homebot.graph import EntityKind, Graph, Node, QoSProfile
from homebot.graph.endpoint import EndpointInfo
from homebot.messages.interfaces.settings import RosSettings


class Meeting:
    """An app at a house, and a robot that is a bare session."""

    def __init__(self, app: Node, robot: ZenohSession) -> None:
        self.app, self.robot = app, robot
        self._declared: list[Declared] = []

    def token(self, kind: EntityKind, name: str, ros_type: str = "", the_hash: str = "") -> EntityToken:
        qos = QoSProfile() if kind in {EntityKind.PUBLISHER, EntityKind.SUBSCRIPTION} else None
        return EntityToken(0, self.robot.id, (0, 7), EndpointInfo(kind, "/rosie/nav", name, ros_type, qos), the_hash)

    def declare(self, token: EntityToken) -> EntityToken:
        """Have *token* from now on."""
        self._declared.append(self.robot.declare_token(token.text))
        return token

    def take_back(self) -> None:
        """Take all tokens back."""
        for one in self._declared:
            one.undeclare()

    async def health(self) -> HealthResponse:
        return await self.app.create_client(GetHealth, "/ros2/health").call(HealthRequest(), PATIENCE)

    async def troubles(self, count: int) -> tuple[str, ...]:
        """Return the troubles once there are *count*."""
        with anyio.fail_after(PATIENCE):
            while len(troubles := (await self.health()).troubles) != count:
                await anyio.lowlevel.checkpoint()
        return troubles


@asynccontextmanager
async def meeting() -> AsyncIterator[Meeting]:
    address = f"tcp/127.0.0.1:{reserve_port()}"
    house = RosSettings.model_validate(
        {"listen": address, "export": ("/house/**",), "import": {"rosie": ("/rosie/**",)}}
    )
    robots = RobotsOnWire(house.imports, {"rosie": access("rosie")})
    async with anyio.create_task_group() as tasks, Node(Graph(), "app") as app:
        await tasks.start(partial(linked, app.graph, "ros2", "/", house, robots))
        link = {"connect": (address,), "export": ("/rosie/**",), "import": {"house": ("/house/**",)}}
        settings = RosSettings.model_validate(link)
        async with open_session(settings, robot_rights(settings, "rosie")) as robot:
            yield Meeting(app, robot)
        tasks.cancel_scope.cancel()
