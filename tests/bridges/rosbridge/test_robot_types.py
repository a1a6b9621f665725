"""The usual messages of a robot, through the door in both directions."""

from __future__ import annotations

import json
from typing import Any

import pytest
from tests.bridges.conftest import House
from tests.messages.test_ros_packages import sample

from homebot.messages.definition import zero_message
from homebot.messages.interfaces import find_message
from homebot.messages.json import message_from_json, message_to_json

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
            listed = {"data": list(data)} if is_listed else {}
            await robot.send("publish", topic=topic, msg=message_to_json(whole) | listed)
            frame = await screen.connection.recv()
            assert len(frame) > 140_000
            if compression == "none":
                assert message_from_json(type(whole), json.loads(frame)["msg"]) == whole
            assert heard.take() == whole
