"""ROS ``std_msgs``: the time and place of a message, and a colour."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Float32, Message

__all__ = ["ColorRGBA", "Header"]


class Header(Message, ros_type="std_msgs/msg/Header"):
    """The time and place to which the other fields of a message belong."""

    stamp: Time
    frame_id: str


class ColorRGBA(Message, ros_type="std_msgs/msg/ColorRGBA"):
    """A colour: red, green, blue and how opaque it is, from 0 to 1 each."""

    r: Float32
    g: Float32
    b: Float32
    a: Float32
