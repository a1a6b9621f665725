"""The simulated house of a run; the code of the house is loaded with this module."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from contextlib import AbstractAsyncContextManager
from dataclasses import replace
from functools import partial
from random import Random
from typing import final

import anyio
from anyio.abc import TaskStatus

from homebot.errors import ConfigError, UsageError
from homebot.gateways import GatewayContext, HostService
from homebot.graph import Graph, Node
from homebot.house import SimulatedHouse, World
from homebot.house.faults import unwrap
from homebot.house.network import HouseNetwork
from homebot.house.robot import Robot
from homebot.runtime.plan import Plan
from homebot.support.isolation import run_as

__all__ = ["HouseOfRun"]

ROBOT = "house.robot"

_FRAMES = ("odom", "base_footprint", "base_link")
_BOOTS = 1.0
"""Seconds that a robot boots longer than a house starts, so that its code does not delay the start."""


@final
class HouseOfRun:
    """A simulated house, with the networks and the broker of its devices.

    Args:
        world: The house as it is described.
        configured: The names of the gateways in the configuration.
        robot: The name of its robot with ROS; empty for none. A house of which no room has an extent has none.
    """

    def __init__(self, world: World, configured: Collection[str], robot: str = "") -> None:
        self._world = world
        self.robot = robot if any(room.corners for room in world.rooms.rooms.values()) else ""
        self._configured = frozenset(configured)
        self._network = HouseNetwork(world.families())

    def gateways(self) -> dict[str, dict[str, object]]:
        """Return the tables of the gateways that find its devices, see :meth:`HouseNetwork.gateways`."""
        return self._network.gateways()

    def places(self) -> dict[str, object]:
        """Return its rooms, doors and positions as a table ``[places]``."""
        from homebot.house.floor import places_table  # noqa: PLC0415 - for a house with a robot

        return places_table(self._world.rooms, self._world.devices)

    def with_its_robot(self, plan: Plan) -> Plan:
        """Return *plan* with the robot and its frames, where robots have tables: else these would be another's."""
        if not plan.names_robots or self.robot in plan.robots:
            return plan
        from homebot.robots import RobotSettings  # noqa: PLC0415 - for a house with several robots

        return replace(plan, robots={**plan.robots, self.robot: RobotSettings(frames=_FRAMES)})

    def running(self, random: Random | None) -> AbstractAsyncContextManager[tuple[object, ...]]:
        """Run its networks, see :meth:`HouseNetwork.running`."""
        return self._network.running(random)

    def check_host(self, needed: Iterable[HostService[object]], source: str) -> None:
        """Check that there is an embedded broker for its devices.

        Raises:
            ConfigError: No in-process peer of this name exists.
        """
        if all(service.kind is not SimulatedHouse.Host for service in needed):
            raise ConfigError(source, "gateways", SimulatedHouse.WITHOUT_HOST)

    def may_meet_real_devices(self, plan: Plan) -> bool:
        """Return whether a gateway of the configuration may find devices outside the house."""
        return any(
            one.name in self._configured
            and all(service.kind is not SimulatedHouse.Host for service in one.kind.host_services(one.settings))
            for one in plan.gateways
        )

    async def serve(
        self,
        context: GatewayContext,
        home: str,
        graph: Graph,
        *,
        task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
    ) -> None:
        """Run the devices at the host in *context* until cancelled.

        Args:
            home: The first level of their topics.
            graph: The graph, on which its robot is.

        Raises:
            UsageError: There is no host.
        """
        host = context.service(SimulatedHouse.Host)
        if host is None:
            raise UsageError(SimulatedHouse.WITHOUT_HOST)
        house = SimulatedHouse.hosted_by(
            host, home, self._world, graph.clock, random=context.random, network=self._network
        )
        if not self.robot:
            await house.serve(task_status=task_status)
            return
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(run_as, "the robot of the house", partial(self._serve_robot, house, graph))
            await house.serve(task_status=task_status)

    async def _serve_robot(self, house: SimulatedHouse, graph: Graph) -> None:
        """Run the robot of the house: the first device that is one, else one that is in the first room."""
        await anyio.sleep(_BOOTS)
        from homebot.house.robot_actions import RobotActions  # noqa: PLC0415 - as above
        from homebot.house.ros_robot import RosRobot  # noqa: PLC0415 - as above

        world, clock = self._world, graph.clock
        devices = [name for name, one in world.devices.items() if isinstance(unwrap(one.device), Robot)]
        first = next(name for name, room in world.rooms.rooms.items() if room.corners)
        own = Robot(self.robot, world.rooms, first)

        def read() -> Robot:
            robot = unwrap(world.device(devices[0])) if devices else own
            own.advance(clock.now())
            assert isinstance(robot, Robot)  # noqa: S101 - as it was found above
            return robot

        def command(text: str) -> None:
            if devices:
                house.command(devices[0], text)
            else:
                own.handle_command(text, clock.now())

        async with Node(graph, self.robot) as node:
            robot = RosRobot(node, read, command)
            RobotActions(robot)
            message = f"the robot is in {read().room}; ask what is near it: homebot find 'light near {self.robot}'"
            node.log.info(ROBOT, message=message)
            await robot.serve()
