"""ROS ``geometry_msgs``: positions and orientations; the rest of the package is built from its definitions."""

from typing import Annotated

from pydantic import Field

from homebot.messages.message import Float64Array, Message
from homebot.messages.std_msgs import Header
from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("geometry_msgs")


class Vector3(Message, ros_type="geometry_msgs/msg/Vector3"):
    """A vector, such as a speed in metres or radians per second."""

    x: float
    y: float
    z: float


class Point(Message, ros_type="geometry_msgs/msg/Point"):
    """A position in metres."""

    x: float
    y: float
    z: float


class Quaternion(Message, ros_type="geometry_msgs/msg/Quaternion"):
    """A rotation; by default the identity."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


class Pose(Message, ros_type="geometry_msgs/msg/Pose"):
    """A position and an orientation."""

    position: Point
    orientation: Quaternion


class Transform(Message, ros_type="geometry_msgs/msg/Transform"):
    """A transform from one coordinate frame to another."""

    translation: Vector3
    rotation: Quaternion


class PoseWithCovariance(Message, ros_type="geometry_msgs/msg/PoseWithCovariance"):
    """An uncertain :class:`Pose`: its covariance has six rows, for x, y, z, and for the rotations about them."""

    pose: Pose
    covariance: Annotated[Float64Array, Field(min_length=36, max_length=36)]


class PoseStamped(Message, ros_type="geometry_msgs/msg/PoseStamped"):
    """A :class:`Pose` at a time, in a frame."""

    header: Header
    pose: Pose


class PoseWithCovarianceStamped(Message, ros_type="geometry_msgs/msg/PoseWithCovarianceStamped"):
    """A :class:`PoseWithCovariance` at a time, in a frame."""

    header: Header
    pose: PoseWithCovariance


class TransformStamped(Message, ros_type="geometry_msgs/msg/TransformStamped"):
    """The transform from the header's frame to another, at a time."""

    header: Header
    child_frame_id: str
    transform: Transform
