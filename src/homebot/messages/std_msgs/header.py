"""ROS ``std_msgs/Header``."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["Header"]


class Header(Message, ros_type="std_msgs/msg/Header"):
    """The time and place to which the other fields of a message belong."""

    stamp: Time
    frame_id: str
