"""Where robots are, by all that is heard of them, in virtual time."""

import sys
from collections import Counter
from collections.abc import AsyncIterator, Iterable, Iterator
from contextlib import asynccontextmanager, contextmanager
from itertools import pairwise
from types import FrameType
from typing import Any

import anyio
import pytest
from tests.control.conftest import OpenHome
from tests.devices.test_robot_owners import tf
from tests.one_task import in_one_task
from tests.set_clock import SetClock

from homebot.clock import Clock
from homebot.devices.names import ROBOT_POSES, WHERE_IS_ROBOT
from homebot.devices.robot_messages import RobotPose, RobotRoom, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.robot_owners import RobotOwners
from homebot.graph import DurabilityPolicy, Graph, Node, Publisher, QoSProfile, Subscription
from homebot.graph.actions import ActionServer
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import (
    Point,
    Pose,
    PoseStamped,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from homebot.messages.interfaces import find_action
from homebot.messages.message import Message
from homebot.messages.nav_msgs import Odometry, Path
from homebot.messages.std_msgs import Header
from homebot.messages.tf2_msgs import TFMessage
from homebot.places import HousePlan, HouseRoom
from homebot.robots.drive import drive
from homebot.robots.settings import RobotSettings
from homebot.robots.tracker import RobotTracker
from homebot.words.steps import SendRobot

pytestmark = pytest.mark.virtual_time

HALL, KITCHEN = ((0.0, 0.0), (4.0, 0.0), (4.0, 5.0), (0.0, 5.0)), ((4.0, 0.0), (8.0, 0.0), (8.0, 5.0), (4.0, 5.0))
HOUSE = HousePlan("h", [HouseRoom("Hall", polygons=((HALL,),)), HouseRoom("Kitchen", polygons=((KITCHEN,),))])
ALL = QoSProfile(depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL)
STILL = Vector3(x=0.0, y=0.0, z=0.0)


class PassingClock(SetClock):
    """A clock that passes between two readings too, as a real one does."""

    passed = 0.0

    def monotonic(self) -> float:
        self.passed += 1e-6
        return super().monotonic() + self.passed


class House:
    """A graph with a tracker, a robot's node, and the poses that are published."""

    def __init__(self, graph: Graph, robot: Node, poses: Subscription[RobotPose]) -> None:
        self.graph, self.robot, self.poses = graph, robot, poses
        self.publishers: dict[str, Publisher[Message]] = {}
        self.where = robot.create_client(WhereIsRobot, WHERE_IS_ROBOT)

    async def say(self, topic: str, message: Message) -> None:
        if topic not in self.publishers:
            self.publishers[topic] = self.robot.create_publisher(type(message), topic)
        self.publishers[topic].publish(message)
        await anyio.sleep(0.15)

    def news(self) -> list[RobotPose]:
        return list(iter(self.poses.take, None))

    async def ask(self, robot: str = "") -> WhereIsRobotResponse:
        return await self.where.call(WhereIsRobotRequest(robot=robot))


@asynccontextmanager
async def house(
    *robots: str,
    guests: Iterable[str] = (),
    settings: dict[str, RobotSettings] | None = None,
    clock: Clock | None = None,
) -> AsyncIterator[House]:
    graph = Graph(clock or PassingClock(1_750_000_000.0))
    owners = RobotOwners(dict.fromkeys(robots or ("rosie",), ()), guests)
    async with Node(graph, "robots") as node, Node(graph, "a_robot") as robot, anyio.create_task_group() as tasks:
        tracker = RobotTracker(node, owners, lambda: HOUSE, settings)
        await tasks.start(tracker.serve)
        yield House(graph, robot, robot.create_subscription(RobotPose, ROBOT_POSES, None, ALL))
        tasks.cancel_scope.cancel()


@pytest.fixture
async def one() -> AsyncIterator[House]:
    """A house with the robot rosie."""
    async with in_one_task(house()) as one:
        yield one


def pose(x: float, y: float) -> Pose:
    return Pose(position=Point(x=x, y=y, z=0.0), orientation=Quaternion(x=0.0, y=0.0, z=0.0, w=1.0))


def header(frame: str = "map", stamp: float = 0.0) -> Header:
    return Header(stamp=Time.from_seconds(stamp), frame_id=frame)


def stamped(x: float, y: float, frame: str = "map", stamp: float = 0.0) -> PoseStamped:
    return PoseStamped(header=header(frame, stamp), pose=pose(x, y))


def amcl(x: float, y: float, sigma: float = 0.1) -> PoseWithCovarianceStamped:
    covariance = [0.0] * 36
    covariance[0] = covariance[7] = sigma**2
    return PoseWithCovarianceStamped(
        header=header(), pose=PoseWithCovariance(pose=pose(x, y), covariance=tuple(covariance))
    )


def odometry(x: float) -> Odometry:
    return Odometry(
        header=header("odom"),
        child_frame_id="base_link",
        pose=PoseWithCovariance(pose=pose(x, 0.0), covariance=(0.0,) * 36),
        twist=TwistWithCovariance(twist=Twist(linear=STILL, angular=STILL), covariance=(0.0,) * 36),
    )


def moved(message: TFMessage, x: float, y: float) -> TFMessage:
    """*message* with the first transform moved."""
    first = message.transforms[0]
    shifted = first.transform.model_copy(update={"translation": Vector3(x=x, y=y, z=0.0)})
    return TFMessage(transforms=(first.model_copy(update={"transform": shifted}), *message.transforms[1:]))


async def test_a_pose_in_map_gives_the_room_and_is_published_once(one: House) -> None:
    await one.say("/robot/pose", stamped(1, 1))
    await one.say("/robot/pose", stamped(1.02, 1))
    [known] = one.news()
    assert (known.robot, known.room, known.x, known.source) == ("rosie", "Hall", 1.0, "/robot/pose")
    await one.say("/rosie/pose", stamped(5, 1))
    assert (await one.ask()).pose[0].room == "Hall"  # both count, and are of the same error
    await anyio.sleep(5)
    assert [(told.room, told.source) for told in one.news()][-2:] == [("Kitchen", "/rosie/pose")] * 2


async def test_a_chain_of_transforms_counts_for_two_seconds_and_expires_once(one: House) -> None:
    chain = tf("map>odom", "odom>base_link")
    await one.say("/tf", moved(chain, 5, 2))
    assert [(told.room, told.x, told.source, told.counts) for told in one.news()] == [("Kitchen", 5.0, "/tf", True)]
    await anyio.sleep(1.5)
    assert one.news() == []
    await anyio.sleep(10)
    assert [(told.room, told.counts) for told in one.news()] == [("Kitchen", False)]
    answer = await one.ask("rosie")
    assert (answer.success, answer.message) == (False, "rosie's pose is 12 s old (limit 2 s)")
    assert answer.pose[0].room == "Kitchen"


async def test_the_pose_of_a_robot_that_stands_is_renewed_every_five_seconds(one: House) -> None:
    for _ in range(200):
        await one.say("/tf", tf("map>odom", "odom>base_link"))
    told = [pose.received_at.to_seconds() for pose in one.news()]
    assert len(told) == 6
    assert all(5 <= after - before < 5.3 for before, after in pairwise(told))


async def test_half_a_chain_that_is_still_received_gives_no_place(one: House) -> None:
    await one.say("/tf", moved(tf("map>odom", "odom>base_link"), 5, 2))
    for _ in range(20):
        await one.say("/tf", tf("odom>base_link"))
    assert [told.counts for told in one.news()] == [True, False]


async def test_odometry_alone_gives_no_place(one: House) -> None:
    await one.say("/tf", tf("odom>base_link"))
    await one.say("/robot/pose", stamped(1, 1, "odom"))
    await one.say("/odom", odometry(1.0))
    refused = "a message on /robot/pose was refused: no static transform connects its frame 'odom' to map"
    assert (await one.ask()).message == f"the position of rosie is not known yet; {refused}"


async def test_a_static_frame_of_the_robot_s_map_gives_a_place(one: House) -> None:
    await one.say("/tf_static", moved(tf("map>rosie/map"), 4, 0))
    await one.say("/rosie/pose", stamped(1, 1, "map"))
    await one.say("/robot/pose", stamped(1, 1, "rosie/map"))
    assert [(told.source, told.x) for told in one.news()] == [("/rosie/pose", 1.0), ("/robot/pose", 5.0)]


async def test_a_parked_robot_counts_while_it_lives_and_no_longer_once_its_odometry_moved(one: House) -> None:
    await one.say("/amcl_pose", amcl(1, 1))
    for _ in range(30):
        await anyio.sleep(2)
        await one.say("/odom", odometry(7.0))
    assert [told.counts for told in one.news()] == [True]
    await one.say("/odom", odometry(7.3))
    assert [told.counts for told in one.news()] == [False]
    await one.say("/amcl_pose", amcl(1.3, 1))
    assert [told.counts for told in one.news()] == [True]
    await anyio.sleep(9.7)
    assert one.news() == []
    await anyio.sleep(0.5)
    assert [told.counts for told in one.news()] == [False]


async def test_the_smaller_error_wins_while_it_counts(one: House) -> None:
    await one.say("/robot/pose", stamped(5, 1))
    await one.say("/amcl_pose", amcl(5, 1, 0.05))
    await one.say("/robot/pose", stamped(5, 1))
    assert [told.source for told in one.news()] == ["/robot/pose", "/amcl_pose"]
    for _ in range(4):
        await anyio.sleep(3)
        await one.say("/rosie/room", RobotRoom(robot="rosie", room="Hall"))
    assert {told.source for told in one.news()} == set()  # each is a sign of life
    await anyio.sleep(11)
    assert [told.source for told in one.news()] == ["/rosie/room"]


async def test_a_pose_of_amcl_that_a_later_position_contradicts_counts_for_ten_seconds(one: House) -> None:
    """A sign of life keeps it only for a robot that is parked."""
    await one.say("/amcl_pose", amcl(5, 1, 0.05))
    for _ in range(6):
        await anyio.sleep(2)
        await one.say("/robot/pose", stamped(1, 1))
    assert [(told.room, told.source) for told in one.news()] == [("Kitchen", "/amcl_pose"), ("Hall", "/robot/pose")]
    await one.say("/amcl_pose", amcl(5, 1, 0.05))
    for _ in range(6):
        await anyio.sleep(2)
        await one.say("/robot/pose", stamped(5.2, 1))
    assert [(told.room, told.source) for told in one.news()][-1] == ("Kitchen", "/amcl_pose")


async def test_frames_follow_a_driving_robot_closer_than_the_poses_of_amcl(one: House) -> None:
    await one.say("/amcl_pose", amcl(1, 1))
    for step in range(30):
        await one.say("/tf", moved(tf("map>odom", "odom>base_link"), 1 + step / 10, 1))
    assert [told.source for told in one.news()][-1] == "/tf"
    assert (await one.ask()).pose[0].x == 3.9


async def test_a_robot_that_is_carried_away_is_unsure_until_three_poses_are_consistent(one: House) -> None:
    await one.say("/robot/pose", stamped(1, 1))
    await one.say("/robot/pose", stamped(6, 1))
    assert [(told.room, told.is_sure) for told in one.news()] == [("Hall", True), ("Kitchen", False)]
    assert "jumped by 5.0 m" in (await one.ask()).message
    for _ in range(2):
        await one.say("/robot/pose", stamped(6, 1))
    assert one.news() == []
    await one.say("/robot/pose", stamped(6, 1))
    assert [told.is_sure for told in one.news()] == [True]
    await one.say("/initialpose", amcl(1, 1))
    assert [told.is_sure for told in one.news()] == [False]


async def test_a_room_that_is_stated_after_a_jump_is_sure_until_the_next_jump(one: House) -> None:
    await one.say("/robot/room", RobotRoom(robot="", room="Hall"))
    await one.say("/robot/pose", stamped(1, 1))
    await one.say("/robot/pose", stamped(6, 1))
    assert [(told.room, told.is_sure) for told in one.news()][-1] == ("Kitchen", False)
    await one.say("/robot/room", RobotRoom(robot="", room="Hall"))
    assert [(told.room, told.is_sure) for told in one.news()] == [("Hall", True)]
    assert (await one.ask()).message == ""
    await one.say("/robot/pose", stamped(1, 1))
    assert [told.is_sure for told in one.news()] == [False]


async def test_a_robot_that_drives_fast_is_sure(one: House) -> None:
    for step in range(8):
        await one.say("/robot/pose", stamped(step * 0.7, 1))
    assert all(told.is_sure for told in one.news())


async def test_an_uncertain_localization_is_unsure(one: House) -> None:
    await one.say("/amcl_pose", amcl(1, 1, 1.5))
    assert [told.is_sure for told in one.news()] == [False]


async def test_a_stamp_far_ahead_of_our_clock_is_refused(one: House) -> None:
    now = one.graph.clock.now()
    await one.say("/robot/pose", stamped(1, 1, stamp=now + 20))
    refused = "a message on /robot/pose was refused: it is 20 s ahead of our clock"
    assert (await one.ask()).message == f"the position of rosie is not known yet; {refused}"
    chain = tf("map>odom", "odom>base_link")
    ahead = tuple(each.model_copy(update={"header": header("map", now + 20)}) for each in chain.transforms[:1])
    await one.say("/tf", TFMessage(transforms=(*ahead, *chain.transforms[1:])))
    assert one.news() == []


async def test_an_old_pose_names_why_later_ones_are_refused(one: House) -> None:
    """A robot without a battery for its clock begins anew at another time."""
    await one.say("/robot/pose", stamped(1, 1, stamp=one.graph.clock.now() + 20))
    await one.say("/robot/pose", stamped(1, 1))
    await anyio.sleep(6)
    assert (await one.ask()).message == "rosie's pose is 6 s old (limit 5 s)"
    await one.say("/robot/pose", stamped(1, 1, "odom"))
    refused = "a message on /robot/pose was refused: no static transform connects its frame 'odom' to map"
    assert (await one.ask()).message == f"rosie's pose is 6 s old (limit 5 s); {refused}"


@pytest.mark.parametrize("huge", [1e200, 1e308, float("inf"), float("nan")])
async def test_a_number_that_is_too_large_is_refused_or_counts_as_no_rotation_and_ends_nothing(
    one: House, huge: float
) -> None:
    await one.say("/robot/pose", stamped(1, huge))
    assert one.news() == []

    turned = Quaternion(x=huge, y=0.0, z=0.0, w=1.0)
    at = stamped(1, 1).pose.model_copy(update={"orientation": turned})
    await one.say("/robot/pose", stamped(1, 1).model_copy(update={"pose": at}))
    await anyio.sleep(0.1)
    assert [(told.room, told.yaw) for told in one.news()] == [("Hall", 0.0)]

    await one.say("/tf", moved(tf("map>odom", "odom>base_link"), huge, 1))
    await anyio.sleep(0.1)
    assert one.news() == []


async def test_the_frames_of_one_robot_leave_room_for_those_of_another() -> None:
    async with house("rosie", "max") as one:
        for begin in range(0, 1500, 500):
            await one.say("/tf", tf(*(f"map>max/frame{index}" for index in range(begin, begin + 500))))
        await one.say("/tf", tf("map>rosie/base_link"))
        await anyio.sleep(0.1)
        assert [told.robot for told in one.news()] == ["rosie"]


async def test_a_clock_that_is_set_makes_no_pose_old_and_refuses_none() -> None:
    """A small computer without a clock of its own sets it some time after its start."""
    clock = SetClock(1_700_000_000.0)
    async with house(clock=clock) as one:
        await one.say("/robot/pose", stamped(1, 1, stamp=clock.now()))
        clock.wall += 3600
        answer = await one.ask()
        assert (answer.success, answer.age < 1) == (True, True)
        await one.say("/robot/pose", stamped(2, 1, stamp=clock.now()))
        [pose] = (await one.ask()).pose
        assert (pose.x, clock.now() - pose.received_at.to_seconds() < 1) == (2.0, True)


async def test_a_room_alone_is_no_position(one: House) -> None:
    await one.say("/rosie/room", RobotRoom(robot="rosie", room="HALL"))
    await one.say("/rosie/room", RobotRoom(robot="bob", room="Kitchen"))
    await one.say("/rosie/room", RobotRoom(robot="rosie", room=" "))
    [known] = one.news()
    assert (known.room, known.has_position, known.limit) == ("Hall", False, 600.0)
    assert known.error == pytest.approx(3.2, abs=0.01)
    await one.say("/rosie/room", RobotRoom(robot="", room="Kitchen"))  # the topic says whose it is
    await anyio.sleep(0.1)
    assert [told.room for told in one.news()] == ["Kitchen"]


async def test_two_robots_by_namespace_and_by_prefixed_frames() -> None:
    async with house("bob", "rosie") as one:
        await one.say("/rosie/tf", moved(tf("map>odom", "odom>base_link"), 5, 2))
        await one.say("/tf", moved(tf("map>bob/odom", "bob/odom>bob/base_link"), 1, 2))
        await one.say("/tf", moved(tf("map>bob/odom", "odom>map"), 7, 2))
        await one.say("/robot/pose", stamped(7, 1))
        assert {(told.robot, told.room) for told in one.news()} == {("rosie", "Kitchen"), ("bob", "Hall")}
        assert (await one.ask()).message == "say which robot: bob, rosie"
        assert (await one.ask("rosi")).message == "there is no robot 'rosi'; did you mean rosie?"
        assert (await one.ask("rosi")).is_mistake
        for name in ("ROSIE", "the Rosie", '"rosie"'):
            assert (await one.ask(name)).pose[0].robot == "rosie"


async def test_a_robot_that_only_a_token_names_is_none_before_its_first_sign_of_life() -> None:
    async def dock(goal: Any) -> None:
        goal.succeed()

    async with house("robot", guests=["rosie"]) as one:
        ActionServer(one.robot, find_action("nav2_msgs/action/DockRobot"), "/dock_robot", dock)
        await one.say("/amcl_pose", amcl(1, 2))
        answer = await one.ask()
        assert (answer.success, answer.robot, answer.is_sole) == (True, "robot", True)
        await drive(one.robot, SendRobot("", "robot", "dock"))
        await one.say("/rosie/pose", stamped(5, 2))
        assert (await one.ask()).message == "say which robot: robot, rosie"
        assert [(known.robot, known.is_sole) for known in [await one.ask(name) for name in ("robot", "rosie")]] == [
            ("robot", True),
            ("rosie", False),
        ]
        await drive(one.robot, SendRobot("", "robot", "dock"))


def path(*points: tuple[float, float]) -> Path:
    return Path(header=header(), poses=tuple(stamped(*point) for point in points))


async def test_the_rooms_on_the_way_of_a_robot_need_light_until_it_is_there(one: House) -> None:
    await one.say("/robot/pose", stamped(1, 1))
    await one.say("/plan", path((1, 1), (7, 4)))
    await one.say("/robot/pose", stamped(5, 1))
    await one.say("/robot/pose", stamped(6.8, 4))
    assert [known.way for known in one.news()] == [(), ("Hall", "Kitchen"), ("Kitchen",), ()]


@pytest.mark.parametrize(("end", "seconds"), [("stands", 60), ("dies", 5), ("gives up", 1)])
async def test_no_room_needs_light_for_a_robot_that_does_not_go_on(one: House, end: str, seconds: float) -> None:
    await one.say("/robot/pose", stamped(1, 1))
    await one.say("/plan", path((1, 1), (7, 4)))
    if end == "gives up":
        await one.say("/plan", path())
    began = one.graph.clock.monotonic()
    while (known := (await one.ask()).pose[0]).way:
        await (anyio.sleep(1) if end == "dies" else one.say("/robot/pose", stamped(1, 1)))
    assert one.graph.clock.monotonic() - began == pytest.approx(seconds, abs=1.1)
    assert known.counts is (end != "dies")


async def test_in_a_doorway_the_robot_stays_in_its_room(one: House) -> None:
    await one.say("/robot/pose", stamped(3.8, 1))
    for x in (4.05, 3.95, 4.1, 3.9, 4.15):
        await one.say("/robot/pose", stamped(x, 1))
    assert {told.room for told in one.news()} == {"Hall"}
    await one.say("/robot/pose", stamped(4.3, 1))
    assert [told.room for told in one.news()] == ["Kitchen"]


@contextmanager
def counted_calls() -> Iterator[Counter[str]]:
    """Count the calls of homebot's own functions inside the block, by file; time would be that of the machine too."""
    found: Counter[str] = Counter()

    def count(frame: FrameType, event: str, _argument: object) -> None:
        if event == "call" and "/homebot/" in (file := frame.f_code.co_filename):
            found[file] += 1

    before = sys.getprofile()
    sys.setprofile(count)
    try:
        yield found
    finally:
        sys.setprofile(before)


async def test_of_frames_that_come_often_only_the_last_of_a_tenth_of_a_second_cost_time(one: House) -> None:
    chain = tf("map>odom", "odom>base_link")
    await one.say("/tf", chain)
    messages = [moved(chain, step / 1000, 1) for step in range(1000)]

    async def stream(pause: float) -> int:
        with counted_calls() as calls:
            for message in messages:
                one.publishers["/tf"].publish(message)
                await anyio.sleep(pause)
        return calls.total()

    seldom, often = await stream(0.2), await stream(0.01)
    assert often < 0.15 * seldom
    assert len(one.news()) <= 100


async def test_a_pose_is_current_when_asked(one: House) -> None:
    chain = tf("map>odom", "odom>base_link")
    await one.say("/tf", chain)
    for step in range(1, 20):
        one.publishers["/tf"].publish(moved(chain, step / 10, 1))
        assert (await one.ask()).pose[0].x == step / 10
        await anyio.sleep(0.01)


async def test_a_motion_sensor_of_a_robot_says_its_room_for_a_minute_whatever_its_link_does(
    open_home: OpenHome,
) -> None:
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
        home.gateway.set_unavailable("its link is cut")
        await anyio.sleep(1)
        assert not (await where.call(WhereIsRobotRequest())).success
        home.gateway.set_available()
        await anyio.sleep(1)
        assert not (await where.call(WhereIsRobotRequest())).success
        await home.report("low motion", "occupancy", False)
        await anyio.sleep(1)
        await home.report("low motion", "occupancy", True)
        await anyio.sleep(1)
        assert (await where.call(WhereIsRobotRequest())).success


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
