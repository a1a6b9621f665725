"""ROS ``sensor_msgs`` of distance sensors."""

from homebot.messages.message import Float32, Float32Array, Message, UInt8, UInt32
from homebot.messages.std_msgs.header import Header

__all__ = ["LaserScan", "PointCloud2", "PointField", "Range"]


class LaserScan(Message, ros_type="sensor_msgs/msg/LaserScan"):
    """One turn of a laser scanner.

    Attributes:
        header: When the first distance was measured; angles turn about the z axis of the frame.
        angle_min: The first angle in radians.
        angle_increment: Radians from one distance to the next.
        time_increment: Seconds from one distance to the next.
        scan_time: Seconds from one scan to the next.
        range_min: Metres; nearer values are invalid.
        range_max: Metres; farther values are invalid.
        ranges: The distances in metres.
        intensities: The strength of each echo; may be empty.
    """

    header: Header
    angle_min: Float32
    angle_max: Float32
    angle_increment: Float32
    time_increment: Float32
    scan_time: Float32
    range_min: Float32
    range_max: Float32
    ranges: Float32Array
    intensities: Float32Array


class Range(Message, ros_type="sensor_msgs/msg/Range"):
    """One distance, as ultrasound and infrared measure it.

    Attributes:
        radiation_type: 0 ultrasound, 1 infrared.
        field_of_view: Width of the cone in radians.
        min_range: Metres; minus infinity says that something is near for a sensor that says no more.
        max_range: Metres.
        range: The distance in metres.
        variance: Its variance, 0 where it is unknown; there since ROS 2 Jazzy.
    """

    header: Header
    radiation_type: UInt8
    field_of_view: Float32
    min_range: Float32
    max_range: Float32
    range: Float32
    variance: Float32


class PointField(Message, ros_type="sensor_msgs/msg/PointField"):
    """One value of each point of a :class:`PointCloud2`.

    Attributes:
        name: Its name, such as ``x`` or ``rgb``.
        offset: Bytes from the start of the point.
        datatype: 1 int8, 2 uint8, 3 int16, 4 uint16, 5 int32, 6 uint32, 7 float32, 8 float64.
    """

    name: str
    offset: UInt32
    datatype: UInt8
    count: UInt32


class PointCloud2(Message, ros_type="sensor_msgs/msg/PointCloud2"):
    """Many points in space, with any values.

    Attributes:
        height: Rows; 1 where the points have no order.
        is_bigendian: Whether the higher byte of a number comes first.
        point_step: Bytes of a point.
        row_step: Bytes of a row.
        is_dense: Whether none of them is invalid.
    """

    header: Header
    height: UInt32
    width: UInt32
    fields: tuple[PointField, ...]
    is_bigendian: bool
    point_step: UInt32
    row_step: UInt32
    data: bytes
    is_dense: bool
