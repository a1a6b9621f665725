"""ROS ``rosgraph_msgs``: the time of a simulation."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.message import Message

__all__ = ["Clock"]


class Clock(Message, ros_type="rosgraph_msgs/msg/Clock"):
    """The time that a simulation has reached, as on ``/clock``."""

    clock: Time
