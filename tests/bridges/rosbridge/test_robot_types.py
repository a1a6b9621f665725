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

TYPES = [
    "diagnostic_msgs/DiagnosticArray",
    "geometry_msgs/PointStamped",
    "geometry_msgs/Polygon",
    "geometry_msgs/PoseArray",
    "geometry_msgs/PoseStamped",
    "geometry_msgs/PoseWithCovarianceStamped",
    "geometry_msgs/TransformStamped",
    "geometry_msgs/Twist",
    "geometry_msgs/TwistStamped",
    "geometry_msgs/Vector3Stamped",
    "geometry_msgs/WrenchStamped",
    "nav_msgs/GridCells",
    "nav_msgs/MapMetaData",
    "nav_msgs/OccupancyGrid",
    "nav_msgs/Odometry",
    "nav_msgs/Path",
    "sensor_msgs/BatteryState",
    "sensor_msgs/CameraInfo",
    "sensor_msgs/CompressedImage",
    "sensor_msgs/Image",
    "sensor_msgs/Imu",
    "sensor_msgs/JointState",
    "sensor_msgs/Joy",
    "sensor_msgs/LaserScan",
    "sensor_msgs/MagneticField",
    "sensor_msgs/NavSatFix",
    "sensor_msgs/PointCloud2",
    "sensor_msgs/Range",
    "sensor_msgs/Temperature",
    "std_msgs/Bool",
    "std_msgs/Float32MultiArray",
    "std_msgs/Header",
    "std_msgs/Int32",
    "std_msgs/String",
    "tf2_msgs/TFMessage",
    "vision_msgs/Detection2DArray",
    "visualization_msgs/Marker",
    "visualization_msgs/MarkerArray",
]


async def test_38_types_pass_both_ways(house: House) -> None:
    assert len(TYPES) == 38
    async with house.node("app") as app, house.peer() as robot, house.peer() as screen:
        for name in TYPES:
            message, topic = sample(find_message(name)), f"/{name.lower()}"
            heard = app.create_subscription(type(message), topic)
            await screen.send("subscribe", topic=topic, type=name)
            await screen.settle()
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
            await screen.send("subscribe", topic=topic, type=name, compression=compression)
            await screen.settle()
            await robot.send("advertise", topic=topic, type=name)
            listed = {"data": list(data)} if is_listed else {}
            await robot.send("publish", topic=topic, msg=message_to_json(whole) | listed)
            frame = await screen.connection.recv()
            assert len(frame) > 140_000
            if compression == "none":
                assert message_from_json(type(whole), json.loads(frame)["msg"]) == whole
            assert heard.take() == whole
