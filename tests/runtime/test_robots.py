"""The tracker of robots in a running homebot: when it starts, and what its tables may say."""

from __future__ import annotations

from pathlib import Path

import anyio
import pytest
from tests.robots.test_tracker import stamped
from tests.robots.test_vacuum import DREAME

from homebot.config import parse_config
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.names import EXPORT_PLACES, ROBOT_POSES, WHERE_IS_ROBOT, GatewayNames
from homebot.devices.places_messages import ExportPlaces, ExportPlacesRequest
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest
from homebot.devices.services import SubscribeToTopic, SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.devices.tags import TagTap
from homebot.errors import ConfigError
from homebot.graph import Node, qos_profile_latched
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import PoseStamped
from homebot.places import read_places
from homebot.runtime import Runtime
from homebot.runtime.plan import make_plan, plan_errors
from homebot.support.toml_file import parse_toml


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


@pytest.mark.virtual_time
async def test_the_named_segments_of_a_vacuum_become_rooms_of_the_house_for_every_robot() -> None:
    vacuum = {"vacuum": "valetudo/dusty", "segments": {"5": "Kitchen"}, "map_transform": [-30.0, -30.0, 0.0]}
    rooms = {"Hall": {"polygon": [[10.0, 0.0], [14.0, 0.0], [14.0, 5.0], [10.0, 5.0]]}}
    tables = {"robots": {"dusty": vacuum, "rosie": {}}, "places": {"rooms": rooms}}
    async with (
        Runtime(parse_config(tables, "homebot.toml"), with_door=False) as runtime,
        Node(runtime.graph, "mqtt", namespace="/gateway") as gateway,
    ):
        names = GatewayNames("mqtt")
        watched = gateway.create_publisher(RawMessage, names.watched)

        def watch(request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
            payload = {"valetudo/dusty/MapData/map-data": DREAME, "valetudo/dusty/$state": b"ready"}.get(request.topic)
            if payload is not None:
                now = Time.from_seconds(runtime.graph.clock.now())
                told = {"gateway": "mqtt", "key": "", "address": request.topic, "retained": True, "received_at": now}
                watched.publish(RawMessage.model_validate({**told, "payload": payload}))
            return SubscribeToTopicResponse(success=True, data_topic=names.watched)

        gateway.create_service(SubscribeToTopic, names.watch, watch)
        await anyio.sleep(2)
        export = gateway.create_client(ExportPlaces, EXPORT_PLACES)
        text = (await export.call(ExportPlacesRequest())).text
        table = parse_toml(text, "")["places"]
        assert isinstance(table, dict)
        rooms_now = read_places(table, "h", "", "import").rooms
        assert {room.name for room in rooms_now if room.polygons} == {"Hall", "Kitchen", "Bad", "Flur"}
        where = gateway.create_client(WhereIsRobot, WHERE_IS_ROBOT)
        poses = gateway.create_publisher(PoseStamped, "/rosie/pose")
        for x, room in ((12.0, "Hall"), (2.77, "Kitchen"), (30.0, "")):
            poses.publish(stamped(x, 3.27))
            await anyio.sleep(0.5)
            assert (await where.call(WhereIsRobotRequest(robot="rosie"))).pose[0].room == room


@pytest.mark.parametrize(
    ("robots", "problem"),
    [
        ({"rosie": {"frame": []}}, "robots.rosie.frame: unknown key; did you mean frames?"),
        ({"rosie": {"limit": 0}}, "robots.rosie.limit: "),
        ({"discovery": {}}, "robots.discovery: is the name of one of homebot's own nodes; choose another name"),
        ({"ro sie": {}}, "robots.ro sie: "),
        ({"rosie": {"map_transform": [0.0, 1.0]}}, "robots.rosie.map_transform"),
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
