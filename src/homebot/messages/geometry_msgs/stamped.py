"""ROS ``geometry_msgs`` with a time and a coordinate frame."""

from homebot.messages.geometry_msgs.values import (
    Accel,
    AccelWithCovariance,
    Inertia,
    Point,
    Polygon,
    PolygonInstance,
    Pose,
    PoseWithCovariance,
    Quaternion,
    Transform,
    Twist,
    TwistWithCovariance,
    Vector3,
    Wrench,
)
from homebot.messages.message import Message
from homebot.messages.std_msgs.header import Header

__all__ = [
    "AccelStamped",
    "AccelWithCovarianceStamped",
    "InertiaStamped",
    "PointStamped",
    "PolygonInstanceStamped",
    "PolygonStamped",
    "PoseArray",
    "PoseStamped",
    "PoseWithCovarianceStamped",
    "QuaternionStamped",
    "TransformStamped",
    "TwistStamped",
    "TwistWithCovarianceStamped",
    "Vector3Stamped",
    "VelocityStamped",
    "WrenchStamped",
]


class PointStamped(Message, ros_type="geometry_msgs/msg/PointStamped"):
    """A :class:`Point` at a time, in a frame."""

    header: Header
    point: Point


class QuaternionStamped(Message, ros_type="geometry_msgs/msg/QuaternionStamped"):
    """A :class:`Quaternion` at a time, in a frame."""

    header: Header
    quaternion: Quaternion


class PoseStamped(Message, ros_type="geometry_msgs/msg/PoseStamped"):
    """A :class:`Pose` at a time, in a frame."""

    header: Header
    pose: Pose


class PoseWithCovarianceStamped(Message, ros_type="geometry_msgs/msg/PoseWithCovarianceStamped"):
    """A :class:`PoseWithCovariance` at a time, in a frame."""

    header: Header
    pose: PoseWithCovariance


class PolygonStamped(Message, ros_type="geometry_msgs/msg/PolygonStamped"):
    """A :class:`Polygon` at a time, in a frame."""

    header: Header
    polygon: Polygon


class PolygonInstanceStamped(Message, ros_type="geometry_msgs/msg/PolygonInstanceStamped"):
    """A :class:`PolygonInstance` at a time, in a frame."""

    header: Header
    polygon: PolygonInstance


class Vector3Stamped(Message, ros_type="geometry_msgs/msg/Vector3Stamped"):
    """A :class:`Vector3` at a time, in a frame."""

    header: Header
    vector: Vector3


class TwistStamped(Message, ros_type="geometry_msgs/msg/TwistStamped"):
    """A :class:`Twist` at a time, in a frame."""

    header: Header
    twist: Twist


class TwistWithCovarianceStamped(Message, ros_type="geometry_msgs/msg/TwistWithCovarianceStamped"):
    """A :class:`TwistWithCovariance` at a time, in a frame."""

    header: Header
    twist: TwistWithCovariance


class AccelStamped(Message, ros_type="geometry_msgs/msg/AccelStamped"):
    """An :class:`Accel` at a time, in a frame."""

    header: Header
    accel: Accel


class AccelWithCovarianceStamped(Message, ros_type="geometry_msgs/msg/AccelWithCovarianceStamped"):
    """An :class:`AccelWithCovariance` at a time, in a frame."""

    header: Header
    accel: AccelWithCovariance


class WrenchStamped(Message, ros_type="geometry_msgs/msg/WrenchStamped"):
    """A :class:`Wrench` at a time, in a frame."""

    header: Header
    wrench: Wrench


class InertiaStamped(Message, ros_type="geometry_msgs/msg/InertiaStamped"):
    """An :class:`Inertia` at a time, in a frame."""

    header: Header
    inertia: Inertia


class PoseArray(Message, ros_type="geometry_msgs/msg/PoseArray"):
    """Many poses in one frame."""

    header: Header
    poses: tuple[Pose, ...]


class TransformStamped(Message, ros_type="geometry_msgs/msg/TransformStamped"):
    """The way from the frame of the header to another, at a time."""

    header: Header
    child_frame_id: str
    transform: Transform


class VelocityStamped(Message, ros_type="geometry_msgs/msg/VelocityStamped"):
    """The speed of one body as another sees it, at a time."""

    header: Header
    body_frame_id: str
    reference_frame_id: str
    velocity: Twist
