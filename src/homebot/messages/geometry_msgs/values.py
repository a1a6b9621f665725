"""ROS ``geometry_msgs`` without a time: places, directions, speeds and forces."""

from typing import Annotated, TypeAlias

from pydantic import Field

from homebot.messages.message import Float32, Float64Array, Int64, Message

__all__ = [
    "Accel",
    "AccelWithCovariance",
    "Inertia",
    "Point",
    "Point32",
    "Polygon",
    "PolygonInstance",
    "Pose",
    "Pose2D",
    "PoseWithCovariance",
    "Quaternion",
    "Transform",
    "Twist",
    "TwistWithCovariance",
    "Vector3",
    "Wrench",
]

_Covariance: TypeAlias = Annotated[Float64Array, Field(min_length=36, max_length=36)]
"""Six rows of six: x, y, z, and the rotations about them."""


class Vector3(Message, ros_type="geometry_msgs/msg/Vector3"):
    """A vector, such as a speed in metres or radians per second."""

    x: float
    y: float
    z: float


class Point(Message, ros_type="geometry_msgs/msg/Point"):
    """A place in metres."""

    x: float
    y: float
    z: float


class Point32(Message, ros_type="geometry_msgs/msg/Point32"):
    """A place in metres, in 32 bits."""

    x: Float32
    y: Float32
    z: Float32


class Quaternion(Message, ros_type="geometry_msgs/msg/Quaternion"):
    """A rotation; without values it is none."""

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 1.0


class Pose(Message, ros_type="geometry_msgs/msg/Pose"):
    """A place and the direction that something has there."""

    position: Point
    orientation: Quaternion


class Pose2D(Message, ros_type="geometry_msgs/msg/Pose2D"):
    """A place on the floor, and the direction there.

    Attributes:
        x: Metres.
        y: Metres.
        theta: Radians.
    """

    x: float
    y: float
    theta: float


class Polygon(Message, ros_type="geometry_msgs/msg/Polygon"):
    """An area with straight edges; the last point is joined with the first."""

    points: tuple[Point32, ...]


class PolygonInstance(Message, ros_type="geometry_msgs/msg/PolygonInstance"):
    """An area that can be told from others."""

    polygon: Polygon
    id: Int64


class Transform(Message, ros_type="geometry_msgs/msg/Transform"):
    """A way from one coordinate frame to another."""

    translation: Vector3
    rotation: Quaternion


class Twist(Message, ros_type="geometry_msgs/msg/Twist"):
    """A speed in space, or a command to drive at it.

    Attributes:
        linear: Metres per second.
        angular: Radians per second.
    """

    linear: Vector3
    angular: Vector3


class Accel(Message, ros_type="geometry_msgs/msg/Accel"):
    """An acceleration in space.

    Attributes:
        linear: Metres per second squared.
        angular: Radians per second squared.
    """

    linear: Vector3
    angular: Vector3


class Wrench(Message, ros_type="geometry_msgs/msg/Wrench"):
    """A force in space.

    Attributes:
        force: Newtons.
        torque: Newton metres.
    """

    force: Vector3
    torque: Vector3


class Inertia(Message, ros_type="geometry_msgs/msg/Inertia"):
    """The mass of a body, and how it is spread.

    Attributes:
        m: Mass in kilograms.
        com: Centre of mass in metres.
        ixx: The first of six elements of the inertia tensor, in kg·m².
    """

    m: float
    com: Vector3
    ixx: float
    ixy: float
    ixz: float
    iyy: float
    iyz: float
    izz: float


class PoseWithCovariance(Message, ros_type="geometry_msgs/msg/PoseWithCovariance"):
    """A :class:`Pose` that is uncertain."""

    pose: Pose
    covariance: _Covariance


class TwistWithCovariance(Message, ros_type="geometry_msgs/msg/TwistWithCovariance"):
    """A :class:`Twist` that is uncertain."""

    twist: Twist
    covariance: _Covariance


class AccelWithCovariance(Message, ros_type="geometry_msgs/msg/AccelWithCovariance"):
    """An :class:`Accel` that is uncertain."""

    accel: Accel
    covariance: _Covariance
