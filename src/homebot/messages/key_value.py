"""ROS ``diagnostic_msgs/KeyValue``, apart from its package: every device has facts, and few programs need the rest."""

from homebot.messages.message import Message

__all__ = ["KeyValue"]


class KeyValue(Message, ros_type="diagnostic_msgs/msg/KeyValue"):
    """One fact, such as one about a device as its gateway received it."""

    key: str
    value: str
