"""What is a robot's, and what a client may state."""

import pytest

from homebot.bridges.rosbridge.access import ClientAccess, MissingRightError
from homebot.bridges.rosbridge.protocol import Advertise, AdvertiseAction, AdvertiseService
from homebot.devices.client_rights import ALL_RIGHTS, LOCAL_RIGHTS
from homebot.devices.robot_messages import RobotRoom
from homebot.devices.robot_owners import RobotOwners
from homebot.errors import UsageError
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Quaternion, Transform, TransformStamped, Vector3
from homebot.messages.std_msgs import Header
from homebot.messages.tf2_msgs import TFMessage
from homebot.words.rights import read_scope

ONE = RobotOwners({"rosie": ()})
ONE_AND_A_GUEST = RobotOwners({"rosie": ()}, ["bob", "rosie"])
TWO = RobotOwners({"rosie": (), "bob": ("gripper",)})


def tf(*frames: str) -> TFMessage:
    def one(frame: str) -> TransformStamped:
        parent, _, child = frame.partition(">")
        turn = Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)
        return TransformStamped(
            header=Header(stamp=Time(sec=0, nanosec=0), frame_id=parent),
            child_frame_id=child,
            transform=Transform(translation=Vector3(x=0.0, y=0.0, z=0.0), rotation=turn),
        )

    return TFMessage(transforms=tuple(map(one, frames)))


@pytest.mark.parametrize(
    ("owners", "topic", "owner"),
    [
        (ONE, "/rosie/anything/at/all", "rosie"),
        (ONE, "/amcl_pose", "rosie"),
        (ONE, "/robot/pose", "rosie"),
        (ONE, "/tf", ""),
        (ONE, "/rosies/pose", None),
        (ONE, "/scan", None),
        (TWO, "/amcl_pose", "?"),
        (TWO, "/robot/pose", "?"),
        (TWO, "/bob/pose", "bob"),
        (RobotOwners(), "/robot/pose", "robot"),
        (RobotOwners(guests=["bob"]), "/robot/pose", "bob"),
        (RobotOwners(guests=["bob", "rosie"]), "/robot/pose", "?"),
        (ONE_AND_A_GUEST, "/amcl_pose", "rosie"),
        (ONE_AND_A_GUEST, "/bob/pose", "bob"),
    ],
)
def test_a_robot_owns_what_is_below_its_name_and_a_sole_one_the_plain_pose_topics(
    owners: RobotOwners, topic: str, owner: str | None
) -> None:
    assert owners.of_topic(topic) == owner


@pytest.mark.parametrize(
    ("owners", "topic", "message", "foreign"),
    [
        (ONE, "/tf", tf("map>odom", "odom>base_link"), ""),
        (ONE, "/tf", tf("map>odom", "odom>map"), "the frame 'map'"),
        (ONE, "/tf", tf("odom>/map"), "the frame 'map'"),
        (ONE, "/tf", tf("odom>stranger/base_link"), "the frame 'stranger/base_link'"),
        (TWO, "/tf", tf("map>rosie/odom", "rosie/odom>rosie/base_link"), ""),
        (TWO, "/tf", tf("map>rosie/odom", "map>bob/odom"), "the frame 'bob/odom'"),
        (TWO, "/tf", tf("map>odom"), "the frame 'odom'"),
        (TWO, "/tf", tf("map>gripper"), "the frame 'gripper'"),
        (TWO, "/rosie/tf", tf("map>odom", "odom>gripper"), ""),
        (TWO, "/rosie/tf", tf("map>bob/odom"), "the frame 'bob/odom'"),
        (TWO, "/rosie/tf", tf("odom>map"), "the frame 'map'"),
        (ONE, "/rosie/room", RobotRoom(robot="rosie", room="Hall"), ""),
        (TWO, "/rosie/room", RobotRoom(robot="bob", room="Hall"), "the robot 'bob'"),
        (TWO, "/elsewhere", tf("odom>map"), ""),
    ],
)
def test_one_foreign_frame_makes_a_message_foreign(
    owners: RobotOwners, topic: str, message: TFMessage | RobotRoom, foreign: str
) -> None:
    assert owners.foreign(topic, message, ["rosie"]) == foreign


def test_a_client_publishes_for_the_robots_of_its_scope_alone() -> None:
    rosie = ClientAccess("rosie", read_scope(["robot: rosie"]), TWO)
    for topic in ("/tf", "/tf_static", "/rosie/tf", "/rosie/pose", "/rosie/battery"):
        rosie.check(Advertise(op="advertise", topic=topic, type="x/msg/X"), str)
    rosie.check(AdvertiseService(op="advertise_service", service="/rosie/dock", type="x/srv/X"), str)
    for topic in ("/bob/pose", "/amcl_pose", "/robot/pose", "/scan", "/robots/poses", "/discovery/changes"):
        with pytest.raises(MissingRightError):
            rosie.check(Advertise(op="advertise", topic=topic, type="x/msg/X"), str)
    rosie.check(AdvertiseAction(op="advertise_action", action="/rosie/spin", type="x/action/X"), str)
    with pytest.raises(MissingRightError, match=r"the right robot is missing; the token rosie has: robot: rosie\. "):
        rosie.check(AdvertiseAction(op="advertise_action", action="/bob/spin", type="x/action/X"), str)
    with pytest.raises(MissingRightError, match=r"'bob/odom'.* is not of the robot rosie"):
        rosie.check_robot("/tf", tf("map>rosie/odom", "map>bob/odom"))


def test_nobody_else_publishes_on_the_topics_of_a_robot() -> None:
    for rights in (LOCAL_RIGHTS, read_scope(["read", "act: all", "manage", "raw"])):
        client = ClientAccess("other", rights, ONE)
        for topic in ("/tf", "/rosie/pose", "/rosie/scan", "/amcl_pose", "/odom", "/robot/pose"):
            with pytest.raises(
                MissingRightError, match=r'NAME --scope "read" --scope "robot: rosie"|add "robot: rosie"'
            ):
                client.check(Advertise(op="advertise", topic=topic, type="x/msg/X"), str)
    ClientAccess("owner", ALL_RIGHTS, TWO).check_robot("/tf", tf("map>bob/odom", "map>rosie/odom"))
    page = ClientAccess.of("local", ALL_RIGHTS, ONE, is_page=True)
    with pytest.raises(MissingRightError):
        page.check(Advertise(op="advertise", topic="/tf", type="x/msg/X"), str)


def test_which_of_several_robots_a_client_is_is_its_own_to_say() -> None:
    with pytest.raises(MissingRightError, match=r'add "robot: NAME" to its scope'):
        ClientAccess("other", LOCAL_RIGHTS, TWO).check(Advertise(op="advertise", topic="/tf", type="x/msg/X"), str)


@pytest.mark.parametrize("scope", ["robot", "robot: ", "robot: a robot", "robot: ros/ie"])
def test_the_right_to_be_a_robot_names_one(scope: str) -> None:
    with pytest.raises(UsageError, match="robot"):
        read_scope([scope])
