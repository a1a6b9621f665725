"""ROS ``diagnostic_msgs``: how the parts of a robot are."""

from homebot.messages.key_value import KeyValue
from homebot.messages.message import Byte, Message
from homebot.messages.std_msgs.header import Header

__all__ = ["DiagnosticArray", "DiagnosticStatus", "KeyValue"]


class DiagnosticStatus(Message, ros_type="diagnostic_msgs/msg/DiagnosticStatus"):
    """The state of one part.

    Attributes:
        level: 0 good, 1 a warning, 2 an error, 3 stale.
    """

    level: Byte
    name: str
    message: str
    hardware_id: str
    values: tuple[KeyValue, ...]


class DiagnosticArray(Message, ros_type="diagnostic_msgs/msg/DiagnosticArray"):
    """The states of many parts."""

    header: Header
    status: tuple[DiagnosticStatus, ...]
