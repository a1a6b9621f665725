"""The robot of the simulated house, in a running homebot in virtual time."""

import math
import tomllib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from itertools import pairwise
from pathlib import Path
from typing import Any

import anyio
import pytest
from anyio import to_thread
from structlog.testing import capture_logs
from tests.whole_house import WHOLE_HOUSE

import homebot.house
from homebot.clock import LoopClock
from homebot.config import parse_config
from homebot.devices import Devices
from homebot.devices.handles import Light
from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.errors import GoalAbortedError
from homebot.graph import Node, qos_profile_latched
from homebot.graph.actions import ActionClient, GoalState
from homebot.house import World, thesis_world
from homebot.house.description import load_world, parse_world
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import Point, Pose, PoseStamped, PoseWithCovarianceStamped, Quaternion
from homebot.messages.interfaces import find_action, find_message
from homebot.messages.message import Message
from homebot.messages.nav_msgs import OccupancyGrid
from homebot.messages.std_msgs import Header
from homebot.messages.tf2_msgs import TFMessage
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime
from homebot.runtime.simulated_house import HouseOfRun

pytestmark = pytest.mark.virtual_time

FAMILY = tomllib.loads((Path(__file__).parents[2] / "examples" / "houses" / "family.toml").read_text("utf-8"))
FAMILY_HOUSE = Path(homebot.house.__file__).parent / "family" / "house.toml"
BATTERY_STATE = find_message("sensor_msgs/msg/BatteryState")
NIGHT = 1_767_225_600.0
"""2026-01-01 00:00 UTC: the robot of the family drives at 10:00."""
CONFIG = {"home": {"name": "home425"}, "gateways": {"mqtt": {"root": "home425"}}}


@asynccontextmanager
async def running(robot: str = "robot", world: World | None = None) -> AsyncIterator[tuple[Runtime, Node]]:
    """Run the small house, or *world*; yield the runtime and a node."""
    async with MemoryBroker() as broker:
        config = parse_config(CONFIG, "test")
        services = (HostedBroker.in_memory(broker),)
        clock = LoopClock(NIGHT)
        runtime = Runtime(
            config, house=world or thesis_world(), robot=robot, clock=clock, with_door=False, services=services
        )
        async with runtime, Node(runtime.graph, "tester") as node:
            yield runtime, node


async def read(node: Node, message_type: type[Message], topic: str) -> list[Any]:
    """Return the list to which each message on *topic* is added."""
    found: list[Any] = []
    node.create_subscription(message_type, topic, found.append, qos_profile_latched)
    await anyio.sleep(0.01)
    return found


async def read_volatile(node: Node, message_type: type[Message], topic: str) -> list[Any]:
    found: list[Any] = []
    node.create_subscription(message_type, topic, found.append, 100)
    await anyio.sleep(0.01)
    return found


async def test_the_robot_of_the_house_is_found_in_its_room_and_stays_known_while_parked() -> None:
    """It counts without a table, and its parked AMCL sends no pose."""
    async with running() as (_, node):
        await anyio.sleep(2)  # it boots
        poses = await read(node, PoseWithCovarianceStamped, "/amcl_pose")
        (grid,) = await read(node, OccupancyGrid, "/map")
        (static,) = await read(node, TFMessage, "/tf_static")
        frames = await read_volatile(node, TFMessage, "/tf")
        batteries = await read_volatile(node, BATTERY_STATE, "/battery_state")
        client = node.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        await anyio.sleep(600)
        found = await client.call(WhereIsRobotRequest())
        assert found.success, found.message
        assert (found.pose[0].robot, found.pose[0].x, found.pose[0].y) == ("robot", 0.0, 0.0)
        assert found.pose[0].room == "Room 405"
        assert len(poses) == 1
        assert isinstance(grid, OccupancyGrid)
        assert grid.info.width * grid.info.height == len(grid.data)
        assert isinstance(static, TFMessage)
        assert {one.child_frame_id for one in static.transforms} == {"base_link"}
        assert 590 <= len(frames) <= 610
        assert (batteries[-1].percentage, batteries[-1].power_supply_status) == (1.0, 4)


@WHOLE_HOUSE
async def test_in_the_hall_of_the_family_the_lamp_of_the_hall_is_the_nearest() -> None:
    """The hall is long: while its lamp had no position, ten metres were added, and the lamp of the study came first."""
    world = await to_thread.run_sync(load_world, FAMILY_HOUSE)
    async with running(world=world) as (_, node):
        await anyio.sleep(1.5)  # then it drives off
        found = await Devices(node).find(Light, near="robot")
        assert found[0].device.id == "hall_lamp"


@WHOLE_HOUSE
def test_a_robot_that_drives_has_the_room_of_its_state_and_no_other() -> None:
    places = HouseOfRun(load_world(FAMILY_HOUSE), ()).places()
    assert places.devices["robots/robot",] == ()


async def test_a_reload_leaves_the_rooms_of_the_house_as_they_are() -> None:
    """A token was added to the configuration, and the robot was in no room from then on."""
    async with running() as (runtime, node):
        await anyio.sleep(2)
        with capture_logs() as lines:
            await runtime.reload(lambda: parse_config(CONFIG, "test"))
        await anyio.sleep(2)
        found = await node.create_client(WhereIsRobot, WHERE_IS_ROBOT).call(WhereIsRobotRequest())
        assert found.pose[0].room == "Room 405"
        assert [one["event"] for one in lines] == ["runtime.reloaded"]


NAVIGATE = find_action("nav2_msgs/action/NavigateToPose")
DOCK = find_action("nav2_msgs/action/DockRobot")
DOCK_TYPE: type[Message] = DOCK.Goal
DOCK_GOAL = zero_message(DOCK_TYPE)


def goal_at(x: float, y: float) -> Message:
    pose = Pose(position=Point(x=x, y=y, z=0.0), orientation=Quaternion())
    stamped = PoseStamped(header=Header(stamp=Time(sec=0, nanosec=0), frame_id="map"), pose=pose)
    goal_type: type[Message] = NAVIGATE.Goal
    empty: Message = zero_message(goal_type)
    return empty.model_copy(update={"pose": stamped})


async def test_it_drives_to_a_pose_and_back_into_its_dock() -> None:
    async with running() as (_, node):
        await anyio.sleep(2)
        poses = await read(node, PoseWithCovarianceStamped, "/amcl_pose")
        batteries = await read_volatile(node, BATTERY_STATE, "/battery_state")
        feedback: list[Any] = []
        navigate, dock = ActionClient(node, NAVIGATE, "/navigate_to_pose"), ActionClient(node, DOCK, "/dock_robot")
        goal = await navigate.send_goal(goal_at(8.5, 1.0), feedback.append)
        state, _ = await goal.result()
        assert state is GoalState.SUCCEEDED
        assert feedback[0].distance_remaining > 8 > feedback[-1].distance_remaining
        client = node.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        await anyio.sleep(1.5)
        found = (await client.call(WhereIsRobotRequest())).pose[0]
        assert (found.room, found.is_sure) == ("Room 165", True)
        assert math.dist((found.x, found.y), (8.5, 1.0)) < 0.25
        driven = len(poses)
        assert driven > 20
        await anyio.sleep(60)
        assert len(poses) == driven
        assert 0 < batteries[-1].percentage < 1
        state, _ = await (await dock.send_goal(DOCK_GOAL)).result()
        assert state is GoalState.SUCCEEDED
        await anyio.sleep(600)
        assert batteries[-1].percentage == 1.0


async def test_a_robot_that_is_a_device_of_the_house_drives_without_a_jump_to_lamps_in_known_rooms() -> None:
    async with running(world=parse_world(FAMILY, "family.toml")) as (_, node):
        await anyio.sleep(5)
        poses = await read(node, PoseWithCovarianceStamped, "/amcl_pose")
        found = await Devices(node).find(Light, near="robot")
        assert [one.area for one in found][:2] == ["hall", "stairs"]
        assert len(found) == 8
        navigate = ActionClient(node, NAVIGATE, "/navigate_to_pose")
        state, _ = await (await navigate.send_goal(goal_at(6.0, 5.0))).result()
        assert state is GoalState.SUCCEEDED
        points = [(one.pose.pose.position.x, one.pose.pose.position.y) for one in poses]
        assert max(math.dist(*pair) for pair in pairwise(points)) < 0.5


async def test_a_cancelled_goal_stops_it_and_a_place_in_no_room_is_refused_with_a_reason() -> None:
    async with running() as (_, node):
        await anyio.sleep(2)
        poses = await read(node, PoseWithCovarianceStamped, "/amcl_pose")
        navigate = ActionClient(node, NAVIGATE, "/navigate_to_pose")
        goal = await navigate.send_goal(goal_at(8.5, 1.0))
        await anyio.sleep(4)
        await goal.cancel()
        state, result = await goal.result()
        assert (state, result.error_code) == (GoalState.CANCELED, 0)
        assert result.error_msg == "its client cancelled it"
        await anyio.sleep(1)
        stopped = len(poses)
        await anyio.sleep(20)
        assert len(poses) == stopped
        state, result = await (await navigate.send_goal(goal_at(99.0, 1.0))).result()
        assert (state, result.error_code) == (GoalState.ABORTED, 207)
        assert result.error_msg == "no room is at 99, 1, or no doors lead to it"
        with pytest.raises(GoalAbortedError, match="action /navigate_to_pose aborted the goal: no room is at 99, 1"):
            await navigate.perform(goal_at(99.0, 1.0))
        elsewhere = DOCK_GOAL.model_copy(update={"use_dock_id": True, "dock_id": "garage"})
        state, result = await (await ActionClient(node, DOCK, "/dock_robot").send_goal(elsewhere)).result()
        assert (state, result.error_code) == (GoalState.ABORTED, 901)
        assert result.error_msg == "there is no dock 'garage'; the only one is dock"


async def test_a_goal_that_another_one_replaces_says_which() -> None:
    """The robot drove to its dock, and the goal to drive said that no room was there."""
    async with running() as (_, node):
        await anyio.sleep(2)
        navigate, dock = ActionClient(node, NAVIGATE, "/navigate_to_pose"), ActionClient(node, DOCK, "/dock_robot")
        first = await navigate.send_goal(goal_at(8.5, 1.0))
        await anyio.sleep(2)
        second = await navigate.send_goal(goal_at(8.0, 1.0))
        state, result = await first.result()
        assert (state, result.error_msg) == (GoalState.ABORTED, "another goal of /navigate_to_pose replaced it")
        await anyio.sleep(2)
        third = await dock.send_goal(DOCK_GOAL)
        state, result = await second.result()
        assert state is GoalState.ABORTED
        assert result.error_msg == "the robot was stopped or sent elsewhere by a goal of /dock_robot"
        state, result = await third.result()
        assert (state, result.success, result.error_msg) == (GoalState.SUCCEEDED, True, "")


async def test_a_goal_that_is_cancelled_once_it_is_reached_succeeds() -> None:
    """As ROS 2 allows: what has been done cannot be undone, and the result says it."""
    async with running() as (_, node):
        await anyio.sleep(2)
        dock = ActionClient(node, DOCK, "/dock_robot")
        state, _ = await (
            await ActionClient(node, NAVIGATE, "/navigate_to_pose").send_goal(goal_at(1.05, 0.0))
        ).result()
        assert state is GoalState.SUCCEEDED
        goal = await dock.send_goal(DOCK_GOAL)
        await anyio.sleep(2.15)  # it took 2.1 s; the next look at it follows at 2.2 s
        assert (await goal.cancel()).return_code == 0
        state, result = await goal.result()
        assert (state, result.success) == (GoalState.SUCCEEDED, True)


async def test_a_house_without_a_robot_gains_nothing() -> None:
    async with running("") as (runtime, _):
        await anyio.sleep(2)
        assert not {"/map", "/tf", "/amcl_pose"} & {one.name for one in runtime.graph.get_endpoints()}
