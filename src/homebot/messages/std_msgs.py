"""ROS ``std_msgs``: single values, and the header; the rest of the package is built from its definitions."""

from homebot.messages import message as fields
from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message
from homebot.messages.text_messages import text_messages

__getattr__ = text_messages("std_msgs")


class Header(Message, ros_type="std_msgs/msg/Header"):
    """The time and the coordinate frame of the other fields of a message."""

    stamp: Time
    frame_id: str


class String(Message, ros_type="std_msgs/msg/String"):
    """A text."""

    data: str


class Bool(Message, ros_type="std_msgs/msg/Bool"):
    """True or false."""

    data: bool


class Int32(Message, ros_type="std_msgs/msg/Int32"):
    """A whole number of 32 bits."""

    data: fields.Int32


class Float64(Message, ros_type="std_msgs/msg/Float64"):
    """A real number of 64 bits."""

    data: fields.Float64
