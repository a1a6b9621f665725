"""ROS ``tf2_msgs``: coordinate frames."""

from homebot.messages.geometry_msgs import TransformStamped
from homebot.messages.message import Message


class TFMessage(Message, ros_type="tf2_msgs/msg/TFMessage"):
    """Transforms between coordinate frames, on ``/tf``."""

    transforms: tuple[TransformStamped, ...]
