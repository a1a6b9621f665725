"""Types at the door: those of ROS, which nobody in the house has to use first, and those that a client defines."""

from __future__ import annotations

import base64
import json
from typing import Any

import pytest
from tests.bridges.conftest import House, Peer
from tests.messages.test_ros_packages import sample

from homebot.bridges.rosbridge.types import find_message_type, find_service_type
from homebot.devices.names import DEFINE_TYPE
from homebot.devices.own_services import right_to_call
from homebot.errors import PeerError
from homebot.graph import Graph, Node
from homebot.messages import Time
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import Twist
from homebot.messages.interfaces import find_message
from homebot.messages.json import message_from_json, message_to_json
from homebot.messages.message import Message
from homebot.messages.std_msgs import Header
from homebot.rights import Right

DRIVE = {"linear": {"x": 0.5, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": -0.25}}


async def test_the_header_of_ros_1_is_taken_without_its_counter(house: House) -> None:
    stamped = {"header": {"seq": 7, "stamp": {"secs": 1, "nsecs": 2}, "frame_id": "map"}, "twist": DRIVE}
    async with house.peer() as robot, house.peer() as old:
        await robot.send("subscribe", topic="/drive", type="geometry_msgs/TwistStamped")
        await robot.tell("subscribe", topic="/header", type="std_msgs/Header")
        await old.send("publish", topic="/drive", msg=stamped)
        header = {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "map"}
        assert (await robot.receive())["msg"] == {"header": header, "twist": DRIVE}
        await old.send("publish", topic="/header", msg=stamped["header"])
        assert (await robot.receive())["msg"] == header


async def test_only_a_header_has_that_counter(house: House, peer: Peer) -> None:
    house.node("robot").create_subscription(Twist, "/cmd_vel")
    await peer.send("publish", topic="/cmd_vel", msg=DRIVE | {"seq": 7})
    assert "field 'seq' is unknown" in (await peer.receive())["msg"]


async def test_a_class_of_an_app_for_a_standard_type_is_used() -> None:
    class Stamped(Message, ros_type="std_msgs/msg/Header"):
        """What an app wrote before there was one here."""

        stamp: Time
        frame_id: str

    async with Node(Graph(), "robot") as node:
        assert find_message_type(node.graph, "std_msgs/Header") is Header
        node.create_publisher(Stamped, "/stamped")
        assert find_message_type(node.graph, "std_msgs/Header") is Stamped


@pytest.mark.parametrize(
    ("wrong", "hint"),
    [
        ("geometry_msgs/Twits", "; similar: geometry_msgs/msg/Twist"),
        ("geometry_msg/msg/Twist", "; similar: geometry_msgs/msg/Twist"),
        ("std_msgs/Duration", ""),
        ("turtlesim/Pose", ""),
        ("homebot/Devic", "; similar: homebot/msg/Device"),
        ("Twist", "; similar: geometry_msgs/msg/Twist"),
    ],
)
async def test_an_unknown_message_type_is_told_with_similar_ones(wrong: str, hint: str) -> None:
    with pytest.raises(PeerError) as refused:
        find_message_type(Graph(), wrong)
    assert str(refused.value) == f"unknown message type {wrong!r}{hint}"


async def test_a_service_type_of_another_package_is_told() -> None:
    """Tutorials of ROS 1 say so."""
    with pytest.raises(PeerError) as refused:
        find_service_type(Graph(), "rospy_tutorials/AddTwoInts")
    assert str(refused.value).endswith("; similar: example_interfaces/srv/AddTwoInts")


ARM = 'float64[] joints\nstring<=8 mode "idle"\nlab/Tool tool\n' + "=" * 80 + "\nMSG: lab/Tool\nint8 kind\n"


async def defined(peer: Any, ros_type: str, definition: str) -> dict[str, Any]:
    await peer.send("call_service", service=DEFINE_TYPE, args={"type": ros_type, "definition": definition})
    answer: dict[str, Any] = (await peer.receive())["values"]
    return answer


async def test_a_client_defines_a_type_that_others_use_too(house: House) -> None:
    async with house.peer() as robot, house.peer() as other:
        answer = await defined(robot, "lab/msg/Arm", ARM)
        assert answer["success"]
        assert answer["type_hash"].startswith("RIHS01_")
        await other.tell("subscribe", topic="/arm", type="lab/Arm")
        await robot.send("advertise", topic="/arm", type="lab/msg/Arm")
        await robot.send("publish", topic="/arm", msg={"joints": [1, 2.5], "tool": {"kind": -1}})
        assert (await other.receive())["msg"] == {"joints": [1.0, 2.5], "mode": "idle", "tool": {"kind": -1}}
        again = await defined(other, "lab/msg/Arm", ARM)
        assert again == answer


@pytest.mark.parametrize(
    ("ros_type", "definition", "problem"),
    [
        ("lab/msg/Arm", "int33 x", "lab/msg/Arm: line 1: 'int33' is not a type"),
        ("std_msgs/Header", "int8 x", "std_msgs/msg/Header is known with other fields"),
        ("../../etc/Passwd", "int8 x", "is not a type; write package/msg/Name"),
        ("lab/msg/Large", "uint8[4000000000] x", "at most 100000"),
    ],
)
async def test_a_wrong_definition_is_answered_with_the_reason(
    house: House, ros_type: str, definition: str, problem: str
) -> None:
    async with house.peer() as robot:
        answer = await defined(robot, ros_type, definition)
        assert not answer["success"]
        assert problem in answer["message"]


def test_to_define_a_type_takes_the_right_to_act() -> None:
    assert right_to_call(DEFINE_TYPE) is Right.ACT


NAMES = {
    "diagnostic_msgs": "DiagnosticArray",
    "geometry_msgs": "PointStamped Polygon PoseArray PoseStamped PoseWithCovarianceStamped "
    "TransformStamped Twist TwistStamped Vector3Stamped WrenchStamped",
    "nav_msgs": "GridCells MapMetaData OccupancyGrid Odometry Path",
    "sensor_msgs": "BatteryState CameraInfo CompressedImage Image Imu JointState Joy LaserScan "
    "MagneticField NavSatFix PointCloud2 Range Temperature",
    "std_msgs": "Bool Float32MultiArray Header Int32 String",
    "tf2_msgs": "TFMessage",
    "vision_msgs": "Detection2DArray",
    "visualization_msgs": "Marker MarkerArray",
}
TYPES = [f"{package}/{name}" for package, names in NAMES.items() for name in names.split()]


async def test_38_types_pass_both_ways(house: House) -> None:
    assert len(TYPES) == 38
    async with house.node("app") as app, house.peer() as robot, house.peer() as screen:
        for name in TYPES:
            message, topic = sample(find_message(name)), f"/{name.lower()}"
            heard = app.create_subscription(type(message), topic)
            await screen.tell("subscribe", topic=topic, type=name)
            await robot.send("advertise", topic=topic, type=name)
            await robot.send("publish", topic=topic, msg=message_to_json(message))
            frame = await screen.receive()
            assert message_from_json(type(message), frame["msg"]) == message == heard.take(), name


@pytest.mark.parametrize("is_listed", [True, False], ids=["as numbers", "as base64"])
@pytest.mark.parametrize("compression", ["none", "cbor"])
async def test_maps_and_raw_images_pass_both_ways(house: House, compression: str, *, is_listed: bool) -> None:
    cells = [-1, 0, 100] * (128 * 384)
    pixels = bytes(range(256)) * (640 * 480 * 3 // 256)
    async with house.node("app") as app, house.peer() as robot, house.peer() as screen:
        samples: tuple[tuple[str, Any], ...] = (("nav_msgs/OccupancyGrid", cells), ("sensor_msgs/Image", pixels))
        for name, data in samples:
            empty, topic = zero_message(find_message(name)), f"/{name.lower()}"
            whole = type(empty)(**{field: getattr(empty, field) for field in type(empty).model_fields} | {"data": data})
            heard = app.create_subscription(type(empty), topic)
            await screen.tell("subscribe", topic=topic, type=name, compression=compression)
            await robot.send("advertise", topic=topic, type=name)
            spelled = list(data) if is_listed else base64.b64encode(bytes(one & 255 for one in data)).decode()
            await robot.send("publish", topic=topic, msg=message_to_json(whole) | {"data": spelled})
            frame = await screen.connection.recv()
            assert len(frame) > 140_000
            if compression == "none":
                assert message_from_json(type(whole), json.loads(frame)["msg"]) == whole
            assert heard.take() == whole
