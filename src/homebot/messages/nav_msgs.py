"""ROS ``nav_msgs``: maps, and where a robot is; the rest of the package is made of its text."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Pose, PoseWithCovariance, TwistWithCovariance
from homebot.messages.message import Float32, Int8Array, Message, UInt32
from homebot.messages.std_msgs import Header
from homebot.messages.text_messages import text_messages

__all__ = ["MapMetaData", "OccupancyGrid", "Odometry"]

__getattr__ = text_messages("nav_msgs")


class Odometry(Message, ros_type="nav_msgs/msg/Odometry"):
    """An estimate of the place and the speed of a robot."""

    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


class MapMetaData(Message, ros_type="nav_msgs/msg/MapMetaData"):
    """The size and the place of a map.

    Attributes:
        resolution: Metres of a cell.
        height: Rows.
    """

    map_load_time: Time
    resolution: Float32
    width: UInt32
    height: UInt32
    origin: Pose


class OccupancyGrid(Message, ros_type="nav_msgs/msg/OccupancyGrid"):
    """An occupancy map.

    Attributes:
        data: The cells row by row: 0 free to 100 occupied, -1 unknown.
    """

    header: Header
    info: MapMetaData
    data: Int8Array
