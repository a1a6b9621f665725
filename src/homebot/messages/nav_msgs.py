"""ROS ``nav_msgs``: maps, ways, and where a robot is."""

from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Point, Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance
from homebot.messages.message import Float32, Int8, Message, UInt32
from homebot.messages.std_msgs.header import Header

__all__ = ["GridCells", "MapMetaData", "OccupancyGrid", "Odometry", "Path"]


class Odometry(Message, ros_type="nav_msgs/msg/Odometry"):
    """An estimate of the place and the speed of a robot.

    Attributes:
        header: When, and the frame of the pose.
        child_frame_id: The frame of the speed: the robot.
        pose: The place.
        twist: The speed.
    """

    header: Header
    child_frame_id: str
    pose: PoseWithCovariance
    twist: TwistWithCovariance


class Path(Message, ros_type="nav_msgs/msg/Path"):
    """A way to drive."""

    header: Header
    poses: tuple[PoseStamped, ...]


class MapMetaData(Message, ros_type="nav_msgs/msg/MapMetaData"):
    """The size and the place of a map.

    Attributes:
        map_load_time: When it was loaded.
        resolution: Metres of a cell.
        width: Cells of a row.
        height: Rows.
        origin: The place of the first cell's corner.
    """

    map_load_time: Time
    resolution: Float32
    width: UInt32
    height: UInt32
    origin: Pose


class OccupancyGrid(Message, ros_type="nav_msgs/msg/OccupancyGrid"):
    """An occupancy map.

    Attributes:
        header: When it was made, and its frame.
        info: Size and place.
        data: The cells row by row: 0 free to 100 occupied, -1 unknown.
    """

    header: Header
    info: MapMetaData
    data: tuple[Int8, ...]


class GridCells(Message, ros_type="nav_msgs/msg/GridCells"):
    """Cells of a map that have something in common.

    Attributes:
        header: When, and the frame of the cells.
        cell_width: Metres.
        cell_height: Metres.
        cells: The centre of each.
    """

    header: Header
    cell_width: Float32
    cell_height: Float32
    cells: tuple[Point, ...]
