"""Rooms of robots by motion sensors, in virtual time."""

import anyio
import pytest
from tests.control.conftest import OpenHome
from tests.robots.test_tracker import HOUSE, amcl

from homebot.devices.names import WHERE_IS_ROBOT
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest
from homebot.devices.robot_owners import RobotOwners
from homebot.graph import Node
from homebot.messages.geometry_msgs import PoseWithCovarianceStamped
from homebot.robots.settings import RobotSettings
from homebot.robots.tracker import RobotTracker

pytestmark = pytest.mark.virtual_time


async def test_a_motion_sensor_of_a_robot_says_its_room_for_a_minute(open_home: OpenHome) -> None:
    async with open_home() as home, Node(home.graph, "robots") as node:
        home.put("low motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        home.put("motion", "occupancy_sensor", readable=("occupancy",), area="kitchen")
        table = RobotSettings(motion_sensors=("Low Motion",))
        home.tasks.start_soon(RobotTracker(node, RobotOwners({"rosie": ()}), lambda: HOUSE, {"rosie": table}).serve)
        where = home.app.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        await anyio.sleep(1)
        await home.report("motion", "occupancy", True)
        await home.report("low motion", "occupancy", True)
        await anyio.sleep(1)
        answer = await where.call(WhereIsRobotRequest())
        assert [(pose.room, pose.has_position, pose.limit) for pose in answer.pose] == [("Hall", False, 60.0)]
        await anyio.sleep(60)
        assert not (await where.call(WhereIsRobotRequest())).success


async def test_a_motion_sensor_does_not_revive_a_pose_of_a_silent_robot(open_home: OpenHome) -> None:
    """A parked robot's pose counts from its own last sign of life."""
    async with open_home() as home, Node(home.graph, "robots") as node, Node(home.graph, "nav") as nav:
        home.put("low motion", "occupancy_sensor", readable=("occupancy",), area="hall")
        table = RobotSettings(motion_sensors=("low motion",))
        home.tasks.start_soon(RobotTracker(node, RobotOwners({"rosie": ()}), lambda: HOUSE, {"rosie": table}).serve)
        where = home.app.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        poses = nav.create_publisher(PoseWithCovarianceStamped, "/amcl_pose")
        await anyio.sleep(1)
        poses.publish(amcl(5, 1))
        await anyio.sleep(1)
        assert (await where.call(WhereIsRobotRequest())).pose[0].source == "/amcl_pose"
        await anyio.sleep(20)
        await home.report("low motion", "occupancy", True)
        await anyio.sleep(1)
        answer = await where.call(WhereIsRobotRequest())
        assert (answer.success, answer.pose[0].room) == (True, "Hall")
