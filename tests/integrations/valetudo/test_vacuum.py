"""A robot vacuum at a broker: its map, and its place in the house, in virtual time."""

import json
import zlib
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest
from structlog.testing import capture_logs
from tests.gateways.mqtt.simple_house import House, simple_house
from tests.robots.test_tracker import ALL, HOUSE

from homebot.devices import SubscribeToTopic
from homebot.devices.devices import Devices
from homebot.devices.names import ROBOT_POSES, WHERE_IS_ROBOT, GatewayNames
from homebot.devices.robot_messages import RobotPose, WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.robot_owners import RobotOwners
from homebot.devices.services import SubscribeToTopicRequest
from homebot.graph import Node, Subscription
from homebot.robots.settings import RobotSettings
from homebot.robots.tracker import RobotTracker

pytestmark = pytest.mark.virtual_time

DREAME = (Path(__file__).parent / "data" / "valetudo_dreame_d9_named_segments.zlib").read_bytes()
VIOMI = (Path(__file__).parent / "data" / "valetudo_viomi_v6_robot_beside_segment.zlib").read_bytes()
BASE = "valetudo/dusty"


class Vacuum:
    """The tracker's side of a house with a vacuum, and its devices' side."""

    def __init__(self, house: House, poses: Subscription[RobotPose]) -> None:
        self._house, self.poses = house, poses
        self._where = house.watcher.create_client(WhereIsRobot, WHERE_IS_ROBOT)

    async def say(self, name: str, payload: str | bytes, base: str = BASE) -> None:
        await self._house.say(f"{base}/{name}", payload, retain=True)
        await anyio.sleep(0.3)

    async def ask(self) -> WhereIsRobotResponse:
        return await self._where.call(WhereIsRobotRequest(robot="dusty"))

    async def cut(self) -> None:
        await self._house.cut()


@asynccontextmanager
async def vacuum(kept: str = "", **settings: object) -> AsyncIterator[Vacuum]:
    table = RobotSettings.model_validate(settings)
    async with (
        simple_house() as house,
        Node(house.graph, "robots") as node,
        anyio.create_task_group() as tasks,
    ):
        await house.say(f"{BASE}/pose", kept, retain=True)
        tracker = RobotTracker(node, RobotOwners({"dusty": ()}), lambda: HOUSE, {"dusty": table})
        await tasks.start(tracker.serve)
        yield Vacuum(house, house.watcher.create_subscription(RobotPose, ROBOT_POSES, None, ALL))
        tasks.cancel_scope.cancel()


async def test_a_docked_vacuum_is_in_the_room_of_its_segment_for_200_seconds() -> None:
    async with vacuum(vacuum=BASE, segments={"5": "Kitchen"}) as dusty:
        await dusty.say("MapData/map-data", DREAME)
        assert (await dusty.ask()).message == "the position of dusty is not known yet"  # a kept map: it may be off
        await dusty.say("$state", "ready")
        [pose] = (await dusty.ask()).pose
        assert (pose.room, pose.is_nearest_room, pose.has_position, pose.limit) == ("Kitchen", False, False, 200.0)
        await anyio.sleep(200)
        assert not (await dusty.ask()).success
        await dusty.say("MapData/map-data", DREAME)
        assert (await dusty.ask()).success


async def test_an_active_vacuum_that_falls_silent_counts_for_three_maps() -> None:
    async with vacuum(vacuum=BASE) as dusty:
        await dusty.say("$state", "ready")
        await dusty.say("StatusStateAttribute/status", "cleaning")
        await dusty.say("MapData/map-data", DREAME)
        assert (await dusty.ask()).pose[0].limit == 24.0
        await anyio.sleep(24)
        assert [told.counts for told in iter(dusty.poses.take, None)] == [True, False]


async def test_a_vacuum_that_is_lost_is_nowhere_at_once() -> None:
    async with vacuum(vacuum=BASE) as dusty:
        await dusty.say("$state", "ready")
        await dusty.say("MapData/map-data", DREAME)
        with capture_logs() as lines:
            await dusty.say("$state", "lost")
        assert [one["message"] for one in lines] == [f"dusty's pose no longer counts (by {BASE}/MapData)"]
        answer = await dusty.ask()
        assert (answer.success, answer.message) == (
            False,
            f"dusty is no longer where it was 1 s ago, by {BASE}/MapData",
        )


async def test_a_vacuum_beside_every_room_is_in_the_nearest_marked_and_farther_away_in_none() -> None:
    elsewhere = json.loads(zlib.decompress(VIOMI))
    elsewhere["entities"][0]["points"] = [0, 0]
    async with vacuum(vacuum=BASE) as dusty:
        await dusty.say("$state", "ready")
        await dusty.say("MapData/map-data", VIOMI)
        [pose] = (await dusty.ask()).pose
        assert (pose.room, pose.is_nearest_room) == ("room1", True)
        await dusty.say("MapData/map-data", json.dumps(elsewhere))
        assert not (await dusty.ask()).success


async def test_with_its_map_in_the_house_it_has_a_position_and_places_other_poses() -> None:
    async with vacuum(vacuum=BASE, segments={"5": "Kitchen"}, map_transform=(-30.0, -30.0, 0.0)) as dusty:
        await dusty.say("$state", "ready")
        await dusty.say("MapData/map-data", DREAME)
        [pose] = (await dusty.ask()).pose
        assert (pose.room, pose.has_position, round(pose.x, 2), round(pose.y, 2)) == ("Kitchen", True, 2.77, 3.27)
        assert (pose.is_nearest_room, pose.error) == (False, 0.25)


async def test_what_is_no_map_costs_one_message(capsys: pytest.CaptureFixture[str]) -> None:
    async with vacuum(vacuum=BASE) as dusty:
        await dusty.say("$state", "ready")
        for number in range(20):
            await dusty.say("MapData/map-data", b"no map %d" % number)
        assert capsys.readouterr().out.count("a map of dusty is not read") == 1
        await dusty.say("$state", b"\xff\xfe")
        await dusty.say("MapData/map-data", DREAME)
        assert (await dusty.ask()).pose[0].room == "dusty room 5"


async def test_a_pose_by_mqtt_counts_as_long_as_it_says_also_after_the_link_was_cut() -> None:
    async with vacuum(topic="dusty/pose", limit=3.0) as dusty:
        for payload in ('{"x": 1}', '{"x": 1, "y": 1e9}', "[]", "{}", '{"x": 1, "y": 2, "limit": -1}'):
            await dusty.say("pose", payload, "dusty")
        assert (await dusty.ask()).pose == ()
        await dusty.say("pose", '{"x": 1, "y": 2, "yaw": 0.5, "error": 0.1}', "dusty")
        [pose] = (await dusty.ask()).pose
        assert (pose.x, pose.y, pose.yaw, pose.error, pose.limit) == (1.0, 2.0, 0.5, 0.1, 3.0)
        await anyio.sleep(3)
        assert not (await dusty.ask()).success
        await dusty.cut()
        await dusty.say("pose", '{"room": "Hall", "limit": 60}', "dusty")
        [pose] = (await dusty.ask()).pose
        assert (pose.room, pose.has_position, pose.limit) == ("Hall", False, 60.0)


async def test_a_pose_that_the_broker_kept_does_not_count_as_its_age_is_unknown() -> None:
    async with vacuum(kept='{"x": 1, "y": 2}', topic=f"{BASE}/pose") as dusty:
        await anyio.sleep(1)
        assert not (await dusty.ask()).success


async def test_a_topic_that_no_device_says_is_for_nodes_with_an_inbox_alone_and_no_device() -> None:
    topic = "valetudo/dusty/MapData/map-data"
    async with simple_house() as house, Node(house.graph, "robots") as node:
        await house.say(topic, DREAME, retain=True)
        heard: list[bytes] = []
        asking = node.create_client(SubscribeToTopic, GatewayNames("mqtt").subscribe)
        for request in (
            SubscribeToTopicRequest(topic=topic, undeclared=True),
            SubscribeToTopicRequest(topic=topic, listener=node.full_name),
        ):
            assert "no device publishes" in (await asking.call(request)).message
        await Devices(node).listen_to(topic, lambda message: heard.append(message.payload))
        await anyio.sleep(1)
        assert heard == [DREAME]
        await house.say(topic, VIOMI, retain=True)
        await anyio.sleep(1)
        assert heard == [DREAME, VIOMI]
        assert house.sighted() == []
