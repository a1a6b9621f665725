"""ROS ``diagnostic_msgs/KeyValue``, separate from its package, the rest of which few programs need."""

from homebot.messages.message import Message


class KeyValue(Message, ros_type="diagnostic_msgs/msg/KeyValue"):
    """One fact, such as one about a device from its gateway."""

    key: str
    value: str
