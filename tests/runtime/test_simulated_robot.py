"""The robot of the simulated house, in a running homebot in virtual time."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager

import anyio
import pytest

from homebot.config import parse_config
from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.graph import Node, qos_profile_latched
from homebot.house import thesis_world
from homebot.messages.geometry_msgs import PoseWithCovarianceStamped
from homebot.messages.message import Message
from homebot.messages.nav_msgs import OccupancyGrid
from homebot.messages.sensor_msgs import BatteryState
from homebot.messages.tf2_msgs import TFMessage
from homebot.mqtt.clients import HostedBroker
from homebot.mqtt.memory_broker import MemoryBroker
from homebot.runtime import Runtime

pytestmark = pytest.mark.virtual_time

CONFIG = {"home": {"name": "home425"}, "gateways": {"mqtt": {"root": "home425"}}}


@asynccontextmanager
async def running(robot: str = "robot") -> AsyncIterator[tuple[Runtime, Node]]:
    """Run the small house; yield the runtime and a node."""
    async with MemoryBroker() as broker:
        config = parse_config(CONFIG, "test")
        services = (HostedBroker.in_memory(broker),)
        runtime = Runtime(config, house=thesis_world(), robot=robot, with_door=False, services=services)
        async with runtime, Node(runtime.graph, "tester") as node:
            yield runtime, node


async def read(node: Node, message_type: type[Message], topic: str) -> list[Message]:
    """Return the list to which each message on *topic* is added."""
    found: list[Message] = []
    node.create_subscription(message_type, topic, found.append, qos_profile_latched)
    await anyio.sleep(0.01)
    return found


async def read_volatile(node: Node, message_type: type[Message], topic: str) -> list[Message]:
    found: list[Message] = []
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
        batteries = await read_volatile(node, BatteryState, "/battery_state")
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
        assert isinstance(batteries[-1], BatteryState)
        assert (batteries[-1].percentage, batteries[-1].power_supply_status) == (1.0, 4)


async def test_a_house_without_a_robot_gains_nothing() -> None:
    async with running("") as (runtime, _):
        await anyio.sleep(2)
        assert not {"/map", "/tf", "/amcl_pose"} & {one.name for one in runtime.graph.get_endpoints()}
