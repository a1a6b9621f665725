"""The tracker of robots in a running homebot: when it starts, and what its tables may say."""

from pathlib import Path

import anyio
import pytest
from tests.robots.test_tracker import stamped

from homebot.config import parse_config
from homebot.devices.names import ROBOT_POSES, WHERE_IS_ROBOT
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest
from homebot.devices.tags import TagTap
from homebot.errors import ConfigError
from homebot.graph import Node, qos_profile_latched
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import PoseStamped
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan, plan_errors


@pytest.mark.virtual_time
async def test_it_starts_with_the_first_pose_topic_and_hears_the_pose_that_started_it() -> None:
    async with Runtime(parse_config({}, "homebot.toml"), with_door=False) as runtime:
        await anyio.sleep(1)
        assert "/robots" not in runtime.graph.get_node_names()
        async with Node(runtime.graph, "a_robot") as robot:
            robot.create_publisher(PoseStamped, "/elsewhere/pose")
            await anyio.sleep(1)
            assert "/robots" not in runtime.graph.get_node_names()
            robot.create_publisher(PoseStamped, "/robot/pose", qos_profile_latched).publish(stamped(1, 2))
            poses = robot.create_subscription(RobotPose, ROBOT_POSES, None, qos_profile_latched)
            with anyio.fail_after(5):
                assert (await poses.receive()).x == 1.0


@pytest.mark.virtual_time
async def test_a_tag_that_a_robot_reads_says_its_room() -> None:
    config = parse_config({"robots": {"rosie": {"tag_reader": "gripper"}}}, "homebot.toml")
    async with Runtime(config, with_door=False) as runtime, Node(runtime.graph, "nfc", namespace="/gateway") as gateway:
        taps = gateway.create_publisher(TagTap, "~/taps")
        for reader, area in (("hall", "Hall"), ("gripper", "Kitchen")):
            taps.publish(TagTap(tag="04a1", reader=reader, area=area, tapped_at=Time.from_seconds(1)))
        await anyio.sleep(0.5)
        answer = await gateway.create_client(WhereIsRobot, WHERE_IS_ROBOT).call(WhereIsRobotRequest())
        [pose] = answer.pose
        assert (pose.robot, pose.room, pose.source, pose.limit) == ("rosie", "Kitchen", "tag 04a1", 600.0)


@pytest.mark.parametrize(
    ("robots", "problem"),
    [
        ({"rosie": {"frame": []}}, "robots.rosie.frame: unknown key; did you mean frames?"),
        ({"rosie": {"limit": 0}}, "robots.rosie.limit: "),
        ({"discovery": {}}, "robots.discovery: robot 'discovery' has the name of homebot's own topics"),
        (
            {"devices": {}},
            "robots.devices: robot 'devices' has the name of homebot's own topics, /devices/",
        ),
        ({"tf": {}}, "robots.tf: robot 'tf' has the name of the topic /tf of all robots; choose another"),
        ({"map": {}}, "robots.map: robot 'map' has the name of the topic /map of all robots; choose another"),
        (
            {"all": {}},
            "robots.all: robot 'all' has the name of all robots in the rights of clients; choose another",
        ),
        ({"ro sie": {}}, "robots.ro sie: "),
        ({"rosie": {"map_transform": [0.0, 1.0]}}, "robots.rosie.map_transform"),
        ({"rosie": {"frames": ["/map"]}}, "robots.rosie.frames: 'map' is a frame of the house already"),
        (
            {"bob": {"frames": ["odom"]}, "rosie": {"frames": ["/odom"]}},
            "robots.rosie.frames: 'odom' is a frame of the robot bob already",
        ),
    ],
)
def test_a_wrong_table_of_a_robot_is_named(robots: dict[str, object], problem: str) -> None:
    with pytest.raises(ConfigError, match="robots") as caught:
        make_plan(parse_config({"robots": robots}, "homebot.toml"))
    assert f"homebot.toml: {problem}" in str(caught.value)


def test_robots_of_tables_and_of_tokens_are_known(tmp_path: Path) -> None:
    file = tmp_path / "bob.token"
    file.touch(mode=0o600)
    file.write_text("secret\n")
    door = {"tokens": {"bob": {"token_file": "bob.token", "scope": ["robot: bob"]}}}
    tables = {"door": door, "robots": {"rosie": {"frames": ["gripper"]}}}
    config = parse_config(tables, "homebot.toml", tmp_path)
    owners = make_plan(config).robot_owners()
    assert (owners.names, owners.of_frame("gripper")) == (("bob", "rosie"), "rosie")
    assert plan_errors(config) == ()
