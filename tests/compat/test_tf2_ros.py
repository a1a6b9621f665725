"""The calls of tf2_ros, as its tutorials have them."""

from collections.abc import Iterator
from typing import Any

import pytest
from tests.patience import PATIENCE

from homebot.compat import rclpy, tf2_ros
from homebot.compat.messages import program_type
from homebot.messages.geometry_msgs import TransformStamped

pytestmark = pytest.mark.slow


@pytest.fixture
def node() -> Iterator[rclpy.Node]:
    rclpy.init()
    yield rclpy.create_node("node")
    rclpy.shutdown()


def transform(node: rclpy.Node, parent: str, child: str, x: float) -> Any:
    found = program_type(TransformStamped)()
    found.header.stamp = node.get_clock().now().to_msg()
    found.header.frame_id, found.child_frame_id = parent, child
    found.transform.translation.x = x
    return found


def test_a_listener_knows_moving_frames_and_static_ones_that_were_sent_before(node: rclpy.Node) -> None:
    static = tf2_ros.StaticTransformBroadcaster(node)
    for number, part in enumerate(("camera", "lidar")):
        static.sendTransform(transform(node, "base", part, number))
    buffer = tf2_ros.Buffer()
    tf2_ros.TransformListener(buffer, node)
    tf2_ros.TransformBroadcaster(node).sendTransform([transform(node, "map", "base", 5.0)])
    wait = rclpy.Duration(seconds=PATIENCE)
    assert buffer.can_transform("map", "camera", rclpy.Time(), wait)
    found = buffer.lookup_transform("map", "lidar", rclpy.Time(), timeout=wait)
    assert (found.header.frame_id, found.child_frame_id, found.transform.translation.x) == ("map", "lidar", 6.0)


def test_a_lookup_that_fails_raises_the_exceptions_of_tf2(node: rclpy.Node) -> None:
    buffer = tf2_ros.Buffer()
    buffer.set_transform_static(transform(node, "base", "camera", 1.0), "test")
    with pytest.raises(tf2_ros.LookupException, match="does not exist"):
        buffer.lookup_transform("map", "camera", rclpy.Time(), rclpy.Duration(seconds=0.02))
    buffer.set_transform(transform(node, "map", "dock", 1.0), "test")
    with pytest.raises(tf2_ros.ConnectivityException):
        buffer.lookup_transform("map", "camera", rclpy.Time())
    assert not buffer.can_transform("map", "camera", rclpy.Time())
