"""ROS ``std_msgs``: one value each."""

from __future__ import annotations

from typing import ClassVar

from homebot.messages import fields
from homebot.messages.message import Message

__all__ = ["Bool", "Empty", "Float32", "Float64", "Int32", "Int64", "String", "UInt8"]


class String(Message):
    """A text."""

    ros_type: ClassVar[str] = "std_msgs/msg/String"

    data: str


class Bool(Message):
    """True or false."""

    ros_type: ClassVar[str] = "std_msgs/msg/Bool"

    data: bool


class UInt8(Message):
    """A whole number from 0 to 255."""

    ros_type: ClassVar[str] = "std_msgs/msg/UInt8"

    data: fields.UInt8


class Int32(Message):
    """A whole number of 32 bits."""

    ros_type: ClassVar[str] = "std_msgs/msg/Int32"

    data: fields.Int32


class Int64(Message):
    """A whole number of 64 bits."""

    ros_type: ClassVar[str] = "std_msgs/msg/Int64"

    data: fields.Int64


class Float32(Message):
    """A real number of 32 bits."""

    ros_type: ClassVar[str] = "std_msgs/msg/Float32"

    data: fields.Float32


class Float64(Message):
    """A real number of 64 bits."""

    ros_type: ClassVar[str] = "std_msgs/msg/Float64"

    data: fields.Float64


class Empty(Message):
    """A signal without a value."""

    ros_type: ClassVar[str] = "std_msgs/msg/Empty"
