"""ROS ``std_msgs`` of one value each."""

from homebot.messages import message as fields
from homebot.messages.message import Message

__all__ = [
    "Bool",
    "Byte",
    "Char",
    "Empty",
    "Float32",
    "Float64",
    "Int8",
    "Int16",
    "Int32",
    "Int64",
    "String",
    "UInt8",
    "UInt16",
    "UInt32",
    "UInt64",
]


class String(Message, ros_type="std_msgs/msg/String"):
    """A text."""

    data: str


class Bool(Message, ros_type="std_msgs/msg/Bool"):
    """True or false."""

    data: bool


class Byte(Message, ros_type="std_msgs/msg/Byte"):
    """Eight bits, as a number from 0 to 255."""

    data: fields.Byte


class Char(Message, ros_type="std_msgs/msg/Char"):
    """A character of eight bits, as a number from 0 to 255."""

    data: fields.Char


class Int8(Message, ros_type="std_msgs/msg/Int8"):
    """A whole number of 8 bits."""

    data: fields.Int8


class Int16(Message, ros_type="std_msgs/msg/Int16"):
    """A whole number of 16 bits."""

    data: fields.Int16


class Int32(Message, ros_type="std_msgs/msg/Int32"):
    """A whole number of 32 bits."""

    data: fields.Int32


class Int64(Message, ros_type="std_msgs/msg/Int64"):
    """A whole number of 64 bits."""

    data: fields.Int64


class UInt8(Message, ros_type="std_msgs/msg/UInt8"):
    """A whole number from 0 to 255."""

    data: fields.UInt8


class UInt16(Message, ros_type="std_msgs/msg/UInt16"):
    """A whole number of 16 bits, from 0."""

    data: fields.UInt16


class UInt32(Message, ros_type="std_msgs/msg/UInt32"):
    """A whole number of 32 bits, from 0."""

    data: fields.UInt32


class UInt64(Message, ros_type="std_msgs/msg/UInt64"):
    """A whole number of 64 bits, from 0."""

    data: fields.UInt64


class Float32(Message, ros_type="std_msgs/msg/Float32"):
    """A real number of 32 bits."""

    data: fields.Float32


class Float64(Message, ros_type="std_msgs/msg/Float64"):
    """A real number of 64 bits."""

    data: fields.Float64


class Empty(Message, ros_type="std_msgs/msg/Empty"):
    """A signal without a value."""
