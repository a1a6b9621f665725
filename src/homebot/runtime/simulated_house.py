"""The simulated house of a run; importing this module loads the code of the house."""

from collections.abc import Collection, Iterator
from dataclasses import replace
from functools import partial
from typing import final

import anyio
from anyio.abc import TaskStatus

from homebot.errors import ConfigError
from homebot.gateways import Gateway, GatewayContext
from homebot.graph import Graph, Node
from homebot.house import SimulatedHouse, World
from homebot.house.dialect import SimulatedDeviceInfo
from homebot.house.family import announces
from homebot.house.faults import unwrap
from homebot.house.network import HouseNetwork
from homebot.house.rooms import DOOR_WIDTH
from homebot.house.simulated_device import Placed
from homebot.places import HouseDoor, HousePlan, HouseRoom, OwnerFact, Places, Position
from homebot.places.plan import door_name
from homebot.runtime.plan import Plan, PlannedComponent
from homebot.support.isolation import run_as

ROBOT = "house.robot"

_STATED = ("configuration", 0.0)
_HOME = "home425"
_FRAMES = ("odom", "base_footprint", "base_link")
_BOOTS = 1.0
"""Seconds by which the robot starts after the house, so that loading its code does not delay the start."""


@final
class HouseOfRun:
    """A simulated house, with the networks and the broker of its devices.

    Args:
        robot: The name of its ROS robot; empty for none. A house without any room extents has no robot.
        broker: The address of the broker of its devices; empty for the one that runs in this process.

    Attributes:
        home: The first level of its devices' topics.
    """

    def __init__(self, world: World, configured: Collection[str], robot: str = "", broker: str = "") -> None:
        self._world = world
        self._broker = broker
        self.robot = robot if any(room.corners for room in world.rooms.rooms.values()) else ""
        self._configured = frozenset(configured)
        self.home, self._has_root = _HOME, True
        self.network = HouseNetwork(world.families())

    def complete(self, plan: Plan, source: str) -> Plan:
        """Return *plan* with the robot of the house, and with its rooms and floor plan if none are stated.

        Raises:
            ConfigError: The plan from the configuration *source* has no in-process peer for the devices, or already
                uses their names.
        """
        if not (self._broker or any(map(_is_host, plan.gateways))):
            raise ConfigError(source, "gateways", SimulatedHouse.WITHOUT_HOST)
        homes = (gateway.kind.home(gateway.settings) for gateway in plan.gateways)
        root = next(filter(None, homes), "")
        self.home, self._has_root = root or _HOME, bool(root)
        if not plan.config.places:
            places = replace(self.places(), groups=plan.places.groups)
            HousePlan(plan.home, places.rooms, source, places.doors)  # validates the names
            plan = replace(plan, places=places)
        if self.robot and plan.names_robots and self.robot not in plan.robots:  # else another would own its frames
            from homebot.robots.settings import RobotSettings  # noqa: PLC0415 - for a house with several robots

            plan = replace(plan, robots={**plan.robots, self.robot: RobotSettings(frames=_FRAMES)})
        return plan

    def may_meet_real_devices(self, plan: Plan) -> bool:
        """Return whether a configured gateway may find devices outside the house."""
        return any(gateway.name in self._configured and not _is_host(gateway) for gateway in plan.gateways)

    def places(self) -> Places:
        """Return the devices in their rooms; with a robot, also the rooms that have an extent, and their doors."""
        rooms, devices = self._world.rooms, self._world.devices
        known_by = {name: identifiers(placed, self.home, has_root=self._has_root) for name, placed in devices.items()}
        facts = {known_by[name]: tuple(_facts(name, placed)) for name, placed in devices.items()}
        if not self.robot:
            return Places((), facts)
        ids = {name: known_by[name][0] for name in devices}
        at_door = {
            (frozenset({placed.room, placed.door}), unwrap(placed.device).kind): ids[name]
            for name, placed in devices.items()
            if placed.door
        }
        doors = []
        for room, other, middle in rooms.doorways():
            contact, lock = (at_door.get((frozenset({room, other}), kind), "") for kind in ("contact", "lock"))
            doors.append(HouseDoor(door_name((room, other)), (room, other), (middle,), DOOR_WIDTH, contact, lock))
        areas = tuple(
            HouseRoom(name, polygons=((room.corners,),)) for name, room in rooms.rooms.items() if room.corners
        )
        return Places(areas, facts, tuple(doors))

    async def serve(
        self,
        context: GatewayContext,
        graph: Graph,
        *,
        task_status: TaskStatus[None] = anyio.TASK_STATUS_IGNORED,
    ) -> None:
        """Run the devices at their broker, by default the host in *context*, until cancelled."""
        host = SimulatedHouse.Host(self._broker) if self._broker else context.service(SimulatedHouse.Host)
        assert host is not None  # noqa: S101 - its plan has one
        house = SimulatedHouse.hosted_by(
            host, self.home, self._world, graph.clock, random=context.random, network=self.network
        )
        if not self.robot:
            await house.serve(task_status=task_status)
            return
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(run_as, "the robot of the house", partial(self._serve_robot, house, graph))
            await house.serve(task_status=task_status)

    async def _serve_robot(self, house: SimulatedHouse, graph: Graph) -> None:
        """Run the robot of the house: its first robot, else one in the first room."""
        await anyio.sleep(_BOOTS)
        from homebot.house import robot, robot_actions, ros_robot  # noqa: PLC0415 - as above

        world, clock = self._world, graph.clock
        devices = [name for name, placed in world.devices.items() if isinstance(unwrap(placed.device), robot.Robot)]
        first = next(name for name, room in world.rooms.rooms.items() if room.corners)
        own = robot.Robot(self.robot, world.rooms, first)

        def read() -> robot.Robot:
            if not devices:
                own.advance(clock.now())
                return own
            house.catch_up()  # the world only advances at events
            simulated = unwrap(world.device(devices[0]))
            assert isinstance(simulated, robot.Robot)  # noqa: S101 - as it was found above
            return simulated

        def command(text: str) -> None:
            if devices:
                house.command(devices[0], text)
            else:
                own.handle_command(text, clock.now())

        async with Node(graph, self.robot) as node:
            served = ros_robot.RosRobot(node, read, command)
            robot_actions.RobotActions(served)
            message = f"the robot is in {read().room}; ask what is near it: homebot find 'light near {self.robot}'"
            node.log.info(ROBOT, message=message)
            await served.serve()


def identifiers(placed: Placed, home: str, *, has_root: bool = True) -> tuple[str, ...]:
    """Return the id of a simulated device in the directory, or the possible id and hardware address.

    Args:
        home: The first level of the devices' topics, on which hardware addresses depend.
        has_root: Whether the gateway listens to that home alone; the id of a device has no home then.
    """
    name, kind = placed.device.device_id, placed.device.service_type
    if not announces(placed.dialect):
        return (f"{kind}/{name}" if has_root else f"{home}/{kind}/{name}",)
    from homebot.house.wire import hardware_address  # noqa: PLC0415 - what announces nothing has none

    address = hardware_address(SimulatedDeviceInfo(home, "", name, kind, placed.room))
    return (name, f"mac:{address}")


def _facts(name: str, placed: Placed) -> Iterator[OwnerFact]:
    """Yield the facts that the owner of a simulated device would state, because few protocols carry rooms or names."""
    if unwrap(placed.device).stays:
        yield OwnerFact("area", placed.room, *_STATED)
    if announces(placed.dialect):
        yield OwnerFact("name", name, *_STATED)
    if placed.at is not None:
        yield OwnerFact("position", Position(*placed.at).text, *_STATED)


def _is_host(gateway: PlannedComponent[Gateway]) -> bool:
    return any(service.kind is SimulatedHouse.Host for service in gateway.kind.host_services(gateway.settings))
