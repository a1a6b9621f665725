"""A robot of a fleet goes to rooms as other robots do: by ``/NAME/navigate_to_pose`` and ``/NAME/dock_robot``."""

import json
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import pytest
from anyio.abc import TaskStatus
from tests.integrations.vda5050.robot import FleetRobot

from homebot.devices.names import ROBOT_POSES, WHERE_IS_ROBOT
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest
from homebot.errors import HomebotError
from homebot.graph import EntityKind, Graph, Node, qos_profile_latched
from homebot.graph.actions import ActionServer
from homebot.messages.interfaces import find_action
from homebot.robots.drive import drive
from homebot.testing import VirtualHouse, virtual_house_of
from homebot.words.steps import SendRobot

pytestmark = [pytest.mark.virtual_time, pytest.mark.rooms("vda5050")]

ROOMS = {
    "Hall": {"polygon": [[0.0, 0.0], [4.0, 0.0], [4.0, 5.0], [0.0, 5.0]]},
    "Kitchen": {"polygon": [[4.0, 0.0], [8.0, 0.0], [8.0, 5.0], [4.0, 5.0]]},
    "Attic": {"polygon": [[9.0, 0.0], [12.0, 0.0], [12.0, 5.0], [9.0, 5.0]]},
}
NODES = {"dock": [1.0, 1.0], "Hall": [2.0, 1.0], "N17": [6.0, 1.0]}


class Peer:
    """A simulated robot at the broker, which says its state at each change and once a second."""

    def __init__(self, house: VirtualHouse, robot: FleetRobot, node: Node) -> None:
        self.house, self.robot, self.node = house, robot, node
        self.orders: list[str] = []

    async def live(self) -> None:
        robot = self.robot
        await self.house.says(robot.connection().topic, robot.connection().payload.decode())
        async with anyio.create_task_group() as tasks:
            for topic in ("order", "instantActions"):
                tasks.start_soon(self._obey, f"{robot.base}/{topic}")
            while True:
                await self.say()
                await anyio.sleep(1)

    async def say(self) -> None:
        state = self.robot.state()
        await self.house.says(state.topic, state.payload.decode())

    async def drive_on(self) -> None:
        """Reach the next node."""
        self.robot.drive()
        await self.say()

    async def _obey(self, topic: str) -> None:
        while True:
            payload = await self.house.hears(topic, within="1d")
            message = json.loads(payload)
            self.orders += [message.get("orderId", "").split(" ")[-1] or message["actions"][0]["actionType"]]
            self.robot.take(topic, payload.encode())
            await self.say()
            self.orders = [order for order in self.orders if order != "stateRequest"]


async def nav2_in(graph: Graph, *, task_status: TaskStatus[None]) -> None:
    """Serve an action of the robot, as its own program does."""

    async def reach(goal: Any) -> None:
        goal.succeed()

    async with Node(graph, "nav2") as node:
        ActionServer(node, find_action("nav2_msgs/action/NavigateToPose"), "/rosie/navigate_to_pose", reach)
        task_status.started()
        await anyio.sleep_forever()


@asynccontextmanager
async def fleet(robot: FleetRobot, *, is_taken: bool = False, **table: Any) -> AsyncIterator[Peer]:
    config = {
        "places": {"rooms": ROOMS},
        "robots": {"rosie": {"topic": f"{robot.base}/state", "segments": {"N17": "Kitchen"}}},
        "gateways": {"mqtt": {"vda5050": {"nodes": NODES, **table}}},
    }
    async with (
        virtual_house_of(config=config) as house,
        Node(house.runtime.graph, "routines_of_test") as node,
        anyio.create_task_group() as tasks,
    ):
        if is_taken:
            await tasks.start(nav2_in, house.runtime.graph)
        peer = Peer(house, robot, node)
        tasks.start_soon(peer.live)
        await house.run_for(5)
        yield peer
        tasks.cancel_scope.cancel()


@asynccontextmanager
async def driving(peer: Peer, room: str) -> AsyncIterator[list[str]]:
    """Send the robot to *room* meanwhile; yields what went wrong, once it has."""
    ended: list[str] = []

    async def go() -> None:
        try:
            await drive(peer.node, SendRobot("", "rosie", room))
            ended.append("arrived")
        except HomebotError as exc:
            ended.append(str(exc))

    async with anyio.create_task_group() as tasks:
        tasks.start_soon(go)
        await anyio.sleep(2)
        yield ended
        tasks.cancel_scope.cancel()


@pytest.mark.parametrize("major", [2, 3])
async def test_a_robot_of_a_fleet_goes_to_a_room_and_to_its_dock_as_others_do(major: int) -> None:
    async with fleet(FleetRobot(major), charger="dock") as peer:
        async with driving(peer, "kitchen") as ended:
            assert (peer.orders, ended) == (["N17"], [])
            await peer.drive_on()
            await anyio.sleep(1)
            assert ended == ["arrived"]
        async with driving(peer, "dock") as ended:
            assert ended == []
            await peer.drive_on()
            await anyio.sleep(30)
            assert ended == ["arrived"]
        assert (peer.robot.node, peer.robot.charging, peer.robot.refused) == ("dock", True, [])
        async with driving(peer, "hall") as ended:
            await anyio.sleep(10)
            await peer.drive_on()
            await anyio.sleep(2)
            assert (ended, peer.robot.node, peer.robot.charging) == (["arrived"], "Hall", False)


async def test_a_drive_that_is_cancelled_is_cancelled_at_the_robot() -> None:
    async with fleet(FleetRobot()) as peer:
        async with driving(peer, "kitchen") as ended:
            assert (peer.robot.ahead, ended) != ([], [])
        await peer.house.run_for(5)
        assert peer.orders == ["N17", "cancelOrder"]
        assert (peer.robot.ahead, peer.robot.node) == ([], "dock")


async def test_a_new_goal_of_either_action_ends_the_last_one() -> None:
    async with fleet(FleetRobot()) as peer, driving(peer, "kitchen") as first, driving(peer, "dock") as second:
        await anyio.sleep(5)
        assert len(first) == 1
        assert peer.orders == ["N17", "cancelOrder", "startCharging"]
        assert second == ["arrived"]


async def test_a_drive_that_the_robot_does_not_finish_says_why() -> None:
    async with fleet(FleetRobot()) as peer:
        async with driving(peer, "kitchen") as ended:
            peer.robot.errors = [{"errorType": "lost", "errorLevel": "FATAL"}]
            await anyio.sleep(3)
            assert "it is error now" in ended[0]
        peer.robot.errors, peer.robot.ahead = [], []
        await anyio.sleep(3)
        async with driving(peer, "kitchen") as ended:
            peer.robot.ahead = []
            await anyio.sleep(3)
            assert "it was sent elsewhere" in ended[0]
        async with driving(peer, "attic") as ended:
            assert "of dock, Hall, N17 none is Attic" in ended[0]


async def test_an_order_that_the_robot_refuses_ends_at_once_with_its_reason() -> None:
    async with fleet(FleetRobot(closed=("N17",))) as peer, driving(peer, "kitchen") as ended:
        assert peer.orders == ["N17"]
        assert ended == [f"{ended[0].partition(':')[0]}: contradicted: orderError (warning): no way to N17"]


async def test_a_robot_that_is_driven_by_hand_refuses() -> None:
    async with fleet(FleetRobot(mode="MANUAL")) as peer, driving(peer, "kitchen") as ended:
        await anyio.sleep(10)
        assert "takes no orders in its mode MANUAL" in ended[0]


@pytest.mark.parametrize("topic", ["uagv/v2/KIT/0001/state", "home425/robots/rosie/pose", "state"])
async def test_only_a_robot_whose_device_takes_such_commands_has_the_actions(topic: str) -> None:
    config = {"robots": {"rosie": {"topic": topic}}, "places": {"rooms": ROOMS}}
    async with virtual_house_of(config=config) as house:
        await house.says("home425/robots/rosie/out", "Hall")  # a robot of another kind, of which little is known
        await house.run_for(5)
        servers = house.runtime.graph.get_endpoints(kind=EntityKind.ACTION_SERVER)
        assert not [one.name for one in servers if one.name.startswith("/rosie/")]


async def test_a_robot_that_has_such_an_action_itself_keeps_it() -> None:
    async with fleet(FleetRobot(), is_taken=True) as peer:
        servers = peer.node.graph.get_endpoints(kind=EntityKind.ACTION_SERVER, name="/rosie/navigate_to_pose")
        assert [one.node for one in servers] == ["/nav2"]


async def test_a_robot_of_a_fleet_on_its_way_needs_light_and_is_gone_by_its_last_will() -> None:
    robot = FleetRobot()
    async with fleet(robot) as peer, driving(peer, "Kitchen"):
        where = peer.node.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        poses = peer.node.create_subscription(RobotPose, ROBOT_POSES, None, qos_profile_latched)
        await peer.house.run_for(6)
        assert [known.way for known in iter(poses.take, None)][-1] == ("Hall", "Kitchen")
        assert not (await where.call(WhereIsRobotRequest(robot="rosie"))).is_gone
        await peer.house.says(robot.last_will.topic, robot.last_will.payload.decode())
        await peer.house.run_for(0.5)
        assert (await where.call(WhereIsRobotRequest(robot="rosie"))).is_gone
