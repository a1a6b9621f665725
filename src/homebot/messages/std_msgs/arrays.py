"""ROS ``std_msgs`` of many numbers each, with the layout of the matrix that they are."""

from homebot.messages import message as fields
from homebot.messages.message import Message, UInt32

__all__ = [
    "ByteMultiArray",
    "Float32MultiArray",
    "Float64MultiArray",
    "Int8MultiArray",
    "Int16MultiArray",
    "Int32MultiArray",
    "Int64MultiArray",
    "MultiArrayDimension",
    "MultiArrayLayout",
    "UInt8MultiArray",
    "UInt16MultiArray",
    "UInt32MultiArray",
    "UInt64MultiArray",
]


class MultiArrayDimension(Message, ros_type="std_msgs/msg/MultiArrayDimension"):
    """One dimension of a matrix.

    Attributes:
        label: Its name, such as ``rows``.
    """

    label: str
    size: UInt32
    stride: UInt32


class MultiArrayLayout(Message, ros_type="std_msgs/msg/MultiArrayLayout"):
    """The dimensions of a matrix that lies in a row.

    Attributes:
        dim: The outermost dimension first.
    """

    dim: tuple[MultiArrayDimension, ...]
    data_offset: UInt32


class ByteMultiArray(Message, ros_type="std_msgs/msg/ByteMultiArray"):
    """A matrix of numbers from 0 to 255, as a list in JSON."""

    layout: MultiArrayLayout
    data: fields.ByteArray


class Int8MultiArray(Message, ros_type="std_msgs/msg/Int8MultiArray"):
    """A matrix of whole numbers of 8 bits."""

    layout: MultiArrayLayout
    data: fields.Int8Array


class Int16MultiArray(Message, ros_type="std_msgs/msg/Int16MultiArray"):
    """A matrix of whole numbers of 16 bits."""

    layout: MultiArrayLayout
    data: fields.Int16Array


class Int32MultiArray(Message, ros_type="std_msgs/msg/Int32MultiArray"):
    """A matrix of whole numbers of 32 bits."""

    layout: MultiArrayLayout
    data: fields.Int32Array


class Int64MultiArray(Message, ros_type="std_msgs/msg/Int64MultiArray"):
    """A matrix of whole numbers of 64 bits."""

    layout: MultiArrayLayout
    data: fields.Int64Array


class UInt8MultiArray(Message, ros_type="std_msgs/msg/UInt8MultiArray"):
    """A matrix of whole numbers from 0 to 255, as ``bytes``."""

    layout: MultiArrayLayout
    data: bytes


class UInt16MultiArray(Message, ros_type="std_msgs/msg/UInt16MultiArray"):
    """A matrix of whole numbers of 16 bits, from 0."""

    layout: MultiArrayLayout
    data: fields.UInt16Array


class UInt32MultiArray(Message, ros_type="std_msgs/msg/UInt32MultiArray"):
    """A matrix of whole numbers of 32 bits, from 0."""

    layout: MultiArrayLayout
    data: fields.UInt32Array


class UInt64MultiArray(Message, ros_type="std_msgs/msg/UInt64MultiArray"):
    """A matrix of whole numbers of 64 bits, from 0."""

    layout: MultiArrayLayout
    data: fields.UInt64Array


class Float32MultiArray(Message, ros_type="std_msgs/msg/Float32MultiArray"):
    """A matrix of real numbers of 32 bits."""

    layout: MultiArrayLayout
    data: fields.Float32Array


class Float64MultiArray(Message, ros_type="std_msgs/msg/Float64MultiArray"):
    """A matrix of real numbers of 64 bits."""

    layout: MultiArrayLayout
    data: fields.Float64Array
