"""The map of a vacuum becomes rooms of a running homebot, in virtual time."""

import json
import math
import zlib
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
from tests.integrations.valetudo.test_vacuum import DREAME
from tests.robots.test_tracker import stamped

from homebot.config import parse_config
from homebot.devices.gateway_messages import RawMessage
from homebot.devices.names import EXPORT_PLACES, WHERE_IS_ROBOT, GatewayNames
from homebot.devices.places_messages import ExportPlaces, ExportPlacesRequest
from homebot.devices.robot_messages import WhereIsRobot, WhereIsRobotRequest, WhereIsRobotResponse
from homebot.devices.services import SubscribeToTopic, SubscribeToTopicRequest, SubscribeToTopicResponse
from homebot.graph import Node
from homebot.integrations.valetudo.formats import read_map
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import PoseStamped
from homebot.places import HouseRoom, read_places
from homebot.places.outline import simplified
from homebot.places.polygon import Polygon
from homebot.places.rigid import MapPose
from homebot.runtime import Runtime
from homebot.support.toml_file import parse_toml

pytestmark = pytest.mark.virtual_time


class VacuumHouse:
    """A running homebot with the vacuum ``dusty``, of which a gateway is played."""

    def __init__(self, runtime: Runtime, gateway: Node) -> None:
        self._clock = runtime.graph.clock
        self.gateway = gateway
        self._inbox = gateway.create_publisher(RawMessage, "/robots/inbox")
        gateway.create_service(SubscribeToTopic, GatewayNames("mqtt").subscribe, self._subscribe)
        self._export = gateway.create_client(ExportPlaces, EXPORT_PLACES)
        self._where = gateway.create_client(WhereIsRobot, WHERE_IS_ROBOT)

    def _subscribe(self, request: SubscribeToTopicRequest) -> SubscribeToTopicResponse:
        missed = (self._message("$state", b"ready"),) if request.topic.endswith("$state") else ()
        return SubscribeToTopicResponse(success=True, data_topic="/robots/inbox", missed=missed)

    def _message(self, name: str, payload: bytes) -> RawMessage:
        topic, now = f"valetudo/dusty/{name}", Time.from_seconds(self._clock.now())
        told = {"gateway": "mqtt", "key": topic, "address": topic, "retained": True, "received_at": now}
        return RawMessage.model_validate({**told, "payload": payload})

    async def say_map(self, payload: bytes) -> None:
        self._inbox.publish(self._message("MapData/map-data", payload))
        await anyio.sleep(2)

    async def rooms(self) -> Sequence[HouseRoom]:
        table = parse_toml((await self._export.call(ExportPlacesRequest())).text, "")["places"]
        assert isinstance(table, dict)
        return read_places(table, "h", "", "import").rooms

    async def areas(self) -> dict[str, float]:
        """Return the rooms that have an area, with its square metres."""
        rooms = await self.rooms()
        return {room.name: round(Polygon(room.polygons[0][0]).area, 1) for room in rooms if room.polygons}

    async def where(self, robot: str = "dusty") -> WhereIsRobotResponse:
        return await self._where.call(WhereIsRobotRequest(robot=robot))


@asynccontextmanager
async def vacuum_house(
    rooms: Mapping[str, object], index: Path | None = None, **vacuum: object
) -> AsyncIterator[VacuumHouse]:
    robots = {"dusty": {"vacuum": "valetudo/dusty", **vacuum}, "rosie": {}}
    config = parse_config({"robots": robots, "places": {"rooms": rooms}}, "homebot.toml")
    async with (
        Runtime(config, with_door=False, index_file=index) as runtime,
        Node(runtime.graph, "mqtt", namespace="/gateway") as node,
    ):
        house = VacuumHouse(runtime, node)
        await anyio.sleep(1)
        yield house


def changed(payload: bytes, **meta: object) -> dict[str, Any]:
    """Return the map in *payload* with other metadata, as JSON."""
    tables: dict[str, Any] = json.loads(zlib.decompress(payload))
    tables["metaData"].update(meta)
    return tables


def packed(tables: dict[str, Any]) -> bytes:
    return zlib.compress(json.dumps(tables).encode())


def without(tables: dict[str, Any], segment: str) -> dict[str, Any]:
    """Return a map without the first half of the runs of one segment."""
    [layer] = [one for one in tables["layers"] if one["metaData"].get("segmentId") == segment]
    runs = layer["compressedPixels"]
    layer["compressedPixels"] = runs[len(runs) // 6 * 3 :]
    return tables


HALL = {"Hall": {"polygon": [[10.0, 0.0], [14.0, 0.0], [14.0, 5.0], [10.0, 5.0]]}}
LIES_AT = [-30.0, -30.0, 0.0]


async def test_the_named_segments_of_a_vacuum_become_rooms_of_the_house_for_every_robot() -> None:
    async with vacuum_house(HALL, segments={"5": "Kitchen"}, map_transform=LIES_AT) as house:
        await house.say_map(DREAME)
        assert (await house.areas()).keys() == {"Hall", "Kitchen", "Bad", "Flur"}
        poses = house.gateway.create_publisher(PoseStamped, "/rosie/pose")
        for x, room in ((12.0, "Hall"), (2.77, "Kitchen"), (30.0, "")):
            poses.publish(stamped(x, 3.27))
            await anyio.sleep(0.5)
            assert (await house.where("rosie")).pose[0].room == room


async def test_rooms_of_a_vacuum_s_map_follow_the_map_and_those_of_the_owner_stay() -> None:
    flur = {"Flur": {"polygon": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]}}
    async with vacuum_house(flur, segments={"5": "Kitchen"}, map_transform=LIES_AT) as house:
        await house.say_map(DREAME)
        before = await house.areas()
        assert before["Flur"] == 1.0
        await house.say_map(packed(without(changed(DREAME), "5")))
        after = await house.areas()
        assert after.pop("Kitchen") < 0.7 * before.pop("Kitchen")
        assert after == before
        tables = changed(DREAME)
        tables["layers"] = [one for one in tables["layers"] if one["metaData"].get("name") != "Bad"]
        await house.say_map(packed(tables))
        assert (await house.areas()).keys() == {"Flur", "Kitchen"}


async def test_rooms_of_a_vacuum_s_map_that_touch_are_joined_also_to_rooms_of_the_owner(tmp_path: Path) -> None:
    file, flur = tmp_path / "index.sqlite3", {"Flur": {"polygon": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]}}
    for names, joined in (({"5": "Kitchen"}, "Bad-Flur"), ({"5": "Kitchen", "6": "Study"}, "Flur-Study Kitchen-Study")):
        async with vacuum_house(flur, file, segments=names, map_transform=LIES_AT) as house:
            await house.say_map(DREAME)
            doors = {"-".join(sorted((room.name, to))) for room in await house.rooms() for to in room.doors}
            assert doors == {"Bad-Flur", *joined.split()}
            assert (await house.areas())["Flur"] == 1.0
            await anyio.sleep(60)


async def test_a_map_that_changed_while_homebot_was_off_changes_its_rooms(tmp_path: Path) -> None:
    file = tmp_path / "index.sqlite3"
    table = {"segments": {"5": "Kitchen"}, "map_transform": LIES_AT}
    async with vacuum_house(HALL, file, **table) as house:
        await house.say_map(DREAME)
        before = await house.areas()
        await anyio.sleep(60)
    tables = without(changed(DREAME), "5")
    tables["layers"] = [one for one in tables["layers"] if one["metaData"].get("name") != "Bad"]
    async with vacuum_house(HALL, file, **table) as house:
        assert await house.areas() == before
        await house.say_map(packed(tables))
        after = await house.areas()
        assert after.keys() == {"Hall", "Kitchen", "Flur"}
        assert after["Kitchen"] < 0.7 * before["Kitchen"]


async def test_on_another_map_of_a_vacuum_nothing_that_was_stated_of_the_first_one_counts() -> None:
    async with vacuum_house({}, segments={"5": "Kitchen"}, map_transform=LIES_AT) as house:
        await house.say_map(DREAME)
        before = await house.areas()
        assert ((await house.where()).pose[0].room, (await house.where()).pose[0].has_position) == ("Kitchen", True)
        await house.say_map(packed(without(changed(DREAME, vendorMapId=77), "5")))
        [pose] = (await house.where()).pose
        assert (pose.has_position, pose.room.startswith("dusty room")) == (False, True)
        assert await house.areas() == before
        await house.say_map(DREAME)
        assert (await house.where()).pose[0].room == "Kitchen"


async def test_a_vacuum_s_map_is_laid_on_three_rooms_of_the_same_names() -> None:
    found, turned = read_map(DREAME), MapPose(-20.0, 7.0, 1.2)
    names = ("Kitchen", "Bath", "Corridor")
    rooms = {}
    for name, segment in zip(names, found.segments[:3], strict=True):
        corners = [turned.then(MapPose(x, y)) for x, y in simplified(found.outline(segment))]
        rooms[name] = {"polygon": [[round(one.x + 0.05, 2), round(one.y, 2)] for one in corners]}
    segments = {segment.id: name for name, segment in zip(names, found.segments[:3], strict=True)}
    async with vacuum_house(rooms, segments=segments) as house:
        await house.say_map(DREAME)
        [pose] = (await house.where()).pose
        assert found.robot is not None
        wanted = turned.then(found.robot)
        assert pose.has_position
        assert math.dist((pose.x, pose.y), (wanted.x, wanted.y)) < 0.2
        assert abs(math.remainder(pose.yaw - wanted.yaw, math.tau)) < 0.05
        areas = await house.areas()
        await house.say_map(packed(changed(DREAME, nonce="other")))
        assert await house.areas() == areas
