"""ROS ``sensor_msgs`` of cameras."""

from typing import Annotated, TypeAlias

from pydantic import Field

from homebot.messages.message import Float64Array, Message, UInt8, UInt32
from homebot.messages.std_msgs.header import Header

__all__ = ["CameraInfo", "CompressedImage", "Image", "RegionOfInterest"]

_Square: TypeAlias = Annotated[Float64Array, Field(min_length=9, max_length=9)]
_Projection: TypeAlias = Annotated[Float64Array, Field(min_length=12, max_length=12)]


class Image(Message, ros_type="sensor_msgs/msg/Image"):
    """A picture as it is.

    Attributes:
        height: Rows.
        width: Columns.
        encoding: The meaning of a pixel, such as ``rgb8``, ``mono8`` or ``16UC1``.
        is_bigendian: 1 where the higher byte of a number comes first.
        step: Bytes of a row.
        data: The rows, the upper one first.
    """

    header: Header
    height: UInt32
    width: UInt32
    encoding: str
    is_bigendian: UInt8
    step: UInt32
    data: bytes


class CompressedImage(Message, ros_type="sensor_msgs/msg/CompressedImage"):
    """A picture as a file.

    Attributes:
        format: ``jpeg`` or ``png``.
    """

    header: Header
    format: str
    data: bytes


class RegionOfInterest(Message, ros_type="sensor_msgs/msg/RegionOfInterest"):
    """A part of a picture; all zero is the whole.

    Attributes:
        x_offset: Its leftmost column.
        y_offset: Its topmost row.
        height: Rows.
        width: Columns.
    """

    x_offset: UInt32
    y_offset: UInt32
    height: UInt32
    width: UInt32
    do_rectify: bool


class CameraInfo(Message, ros_type="sensor_msgs/msg/CameraInfo"):
    """The calibration of a camera.

    Attributes:
        height: Rows of the sensor.
        width: Columns of the sensor.
        distortion_model: The meaning of ``d``, such as ``plumb_bob``.
        binning_x: Columns that are one column of the picture; 0 is 1.
        binning_y: Rows that are one row of the picture; 0 is 1.
    """

    header: Header
    height: UInt32
    width: UInt32
    distortion_model: str
    d: Float64Array
    k: _Square
    r: _Square
    p: _Projection
    binning_x: UInt32
    binning_y: UInt32
    roi: RegionOfInterest
