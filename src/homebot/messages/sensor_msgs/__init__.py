"""ROS ``sensor_msgs``: the types that a robot in a house and its viewers use."""

from homebot.messages.sensor_msgs.images import CameraInfo, CompressedImage, Image, RegionOfInterest
from homebot.messages.sensor_msgs.motion import (
    Imu,
    JointState,
    Joy,
    JoyFeedback,
    JoyFeedbackArray,
    MagneticField,
    NavSatFix,
    NavSatStatus,
    TimeReference,
)
from homebot.messages.sensor_msgs.quantities import (
    BatteryState,
    FluidPressure,
    Illuminance,
    RelativeHumidity,
    Temperature,
)
from homebot.messages.sensor_msgs.ranges import LaserScan, PointCloud2, PointField, Range

__all__ = [
    "BatteryState",
    "CameraInfo",
    "CompressedImage",
    "FluidPressure",
    "Illuminance",
    "Image",
    "Imu",
    "JointState",
    "Joy",
    "JoyFeedback",
    "JoyFeedbackArray",
    "LaserScan",
    "MagneticField",
    "NavSatFix",
    "NavSatStatus",
    "PointCloud2",
    "PointField",
    "Range",
    "RegionOfInterest",
    "RelativeHumidity",
    "Temperature",
    "TimeReference",
]
