"""ROS ``sensor_msgs`` of where something is and how it moves."""

from typing import Annotated, TypeAlias

from pydantic import Field

from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs.values import Quaternion, Vector3
from homebot.messages.message import Float32, Float32Array, Float64Array, Int8, Int32Array, Message, UInt8, UInt16
from homebot.messages.std_msgs.header import Header

__all__ = [
    "Imu",
    "JointState",
    "Joy",
    "JoyFeedback",
    "JoyFeedbackArray",
    "MagneticField",
    "NavSatFix",
    "NavSatStatus",
    "TimeReference",
]

_Covariance: TypeAlias = Annotated[Float64Array, Field(min_length=9, max_length=9)]
"""Three rows of three: x, y, z."""


class Imu(Message, ros_type="sensor_msgs/msg/Imu"):
    """The motion that an inertial unit measures; the first element of a covariance is -1 where the value is unknown.

    Attributes:
        orientation_covariance: Of the direction; all zero is unknown.
        angular_velocity: Radians per second.
        linear_acceleration: Metres per second squared.
    """

    header: Header
    orientation: Quaternion
    orientation_covariance: _Covariance
    angular_velocity: Vector3
    angular_velocity_covariance: _Covariance
    linear_acceleration: Vector3
    linear_acceleration_covariance: _Covariance


class MagneticField(Message, ros_type="sensor_msgs/msg/MagneticField"):
    """The magnetic field at a place.

    Attributes:
        magnetic_field: Tesla.
    """

    header: Header
    magnetic_field: Vector3
    magnetic_field_covariance: _Covariance


class JointState(Message, ros_type="sensor_msgs/msg/JointState"):
    """The joints of a robot; each list is as long as ``name``, or empty.

    Attributes:
        position: Radians or metres.
        velocity: Radians or metres per second.
        effort: Newton metres or newtons.
    """

    header: Header
    name: tuple[str, ...]
    position: Float64Array
    velocity: Float64Array
    effort: Float64Array


class Joy(Message, ros_type="sensor_msgs/msg/Joy"):
    """The axes and buttons of a joystick.

    Attributes:
        axes: From -1 to 1.
        buttons: 1 where one is pressed.
    """

    header: Header
    axes: Float32Array
    buttons: Int32Array


class JoyFeedback(Message, ros_type="sensor_msgs/msg/JoyFeedback"):
    """A feedback command to a joystick.

    Attributes:
        type: 0 a lamp, 1 rumble, 2 a buzzer.
        id: Which one of that type, from 0.
        intensity: From 0 to 1.
    """

    type: UInt8
    id: UInt8
    intensity: Float32


class JoyFeedbackArray(Message, ros_type="sensor_msgs/msg/JoyFeedbackArray"):
    """All that a joystick shall do."""

    array: tuple[JoyFeedback, ...]


class NavSatStatus(Message, ros_type="sensor_msgs/msg/NavSatStatus"):
    """The quality of a position from satellites.

    Attributes:
        status: -1 none, 0 a fix, 1 with corrections by satellite, 2 by ground station.
        service: The sum of 1 GPS, 2 GLONASS, 4 Compass, 8 Galileo.
    """

    status: Int8
    service: UInt16


class NavSatFix(Message, ros_type="sensor_msgs/msg/NavSatFix"):
    """A position from satellites, in WGS 84.

    Attributes:
        latitude: Degrees north.
        longitude: Degrees east.
        altitude: Metres above the ellipsoid; NaN where it is unknown.
        position_covariance: Square metres, of east, north and up.
        position_covariance_type: 0 unknown, 1 approximate, 2 the diagonal is known, 3 known.
    """

    header: Header
    status: NavSatStatus
    latitude: float
    longitude: float
    altitude: float
    position_covariance: _Covariance
    position_covariance_type: UInt8


class TimeReference(Message, ros_type="sensor_msgs/msg/TimeReference"):
    """The time by another clock."""

    header: Header
    time_ref: Time
    source: str
