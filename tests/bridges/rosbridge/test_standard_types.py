"""The messages and services of ROS's packages at the door, which nobody in the house has to use first."""

from __future__ import annotations

import pytest
from tests.bridges.conftest import House, Peer

from homebot.bridges.rosbridge.types import find_message_type, find_service_type
from homebot.errors import PeerError
from homebot.graph import Graph, Node
from homebot.messages import Time
from homebot.messages.geometry_msgs import Twist
from homebot.messages.message import Message
from homebot.messages.std_msgs import Header

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
