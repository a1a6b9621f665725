"""The robot of a simulated house as a ROS robot: its map, frames, pose and battery on the graph."""

import math
from array import array
from collections.abc import Callable, Iterator
from typing import Any, Final, final

import anyio

from homebot.graph import Node, qos_profile_latched
from homebot.house.robot import Robot
from homebot.house.rooms import DOOR_WIDTH, OUTSIDE, Rooms
from homebot.messages.builtin_interfaces import Time
from homebot.messages.definition import zero_message
from homebot.messages.geometry_msgs import (
    Point,
    Pose,
    PoseStamped,
    PoseWithCovariance,
    PoseWithCovarianceStamped,
    Quaternion,
    Transform,
    TransformStamped,
    Vector3,
)
from homebot.messages.interfaces import find_message
from homebot.messages.nav_msgs import MapMetaData, OccupancyGrid, Path
from homebot.messages.std_msgs import Header
from homebot.messages.tf2_msgs import TFMessage
from homebot.places.rigid import MapPose

_CELL: Final = 0.05
"""Width of a cell of the map in metres."""

_FREE, _OCCUPIED, _UNKNOWN = 0, 100, 255

_DRIVING: Final = 0.1
_PARKED: Final = 1.0
"""Seconds between messages on ``/tf``."""

_MOVED: Final = 0.25
_TURNED: Final = 0.2
"""Metres and radians after which AMCL publishes the next pose; none while it is parked."""

_VARIANCE: Final = 0.01
_HEIGHT: Final = 0.1
_DRAINS: Final = 1 / 7200
_CHARGES: Final = 1 / 3600
"""Change of the battery per second, as a share of full, while driving and in the dock."""

_CHARGING, _DISCHARGING, _FULL = 1, 2, 4
_BATTERY: Final = {
    **dict.fromkeys(("temperature", "current", "charge", "capacity", "design_capacity"), math.nan),
    "voltage": 14.4,
    "present": True,
}


@final
class RosRobot:
    """Publishes ``/map``, ``/tf``, ``/tf_static``, ``/amcl_pose``, ``/plan`` and ``/battery_state`` of one robot.

    Attributes:
        dock: The position of its dock, where it starts.
    """

    def __init__(self, node: Node, read: Callable[[], Robot], command: Callable[[str], None]) -> None:
        self.node = node
        self.read = read
        self.dock = read().pose()
        self._command = command
        self._clock = node.graph.clock
        self._woken = anyio.Event()
        self._charge = 1.0
        self._charged_at = self._clock.monotonic()
        self._last: MapPose | None = None
        self._battery_type = find_message("sensor_msgs/msg/BatteryState")
        map_publisher = node.create_publisher(OccupancyGrid, "/map", qos_profile_latched)
        static = node.create_publisher(TFMessage, "/tf_static", qos_profile_latched)
        self._tf = node.create_publisher(TFMessage, "/tf", 100)
        self._amcl = node.create_publisher(PoseWithCovarianceStamped, "/amcl_pose", qos_profile_latched)
        self._plan = node.create_publisher(Path, "/plan")
        self._way: tuple[tuple[float, float], ...] = ()
        self._battery = node.create_publisher(self._battery_type, "/battery_state", 10)
        map_publisher.publish(occupancy_grid(read().rooms, self.header("map").stamp))
        static.publish(TFMessage(transforms=(self._transform("base_footprint", "base_link", 0.0, 0.0, _HEIGHT),)))

    async def serve(self) -> None:
        """Publish until cancelled."""
        while True:
            robot = self.read()
            pose = robot.pose()
            start = self.dock
            origin = self._transform("map", "odom", start.x, start.y)
            driven = self._transform("odom", "base_footprint", pose.x - start.x, pose.y - start.y, yaw=pose.yaw)
            self._tf.publish(TFMessage(transforms=(origin, driven)))
            if self._last is None or _has_moved(self._last, pose):
                self._last = pose
                covariance = [0.0] * 36
                covariance[0] = covariance[7] = covariance[35] = _VARIANCE
                stated = PoseWithCovariance(pose=ros_pose(pose), covariance=covariance)
                self._amcl.publish(PoseWithCovarianceStamped(header=self.header("map"), pose=stated))
            if (way := robot.way()) != self._way:
                self._way, header = way, self.header("map")
                poses = tuple(PoseStamped(header=header, pose=ros_pose(MapPose(*point, 0.0))) for point in way)
                self._plan.publish(Path(header=header, poses=poses))
            self._battery.publish(self._battery_state(robot))
            self._woken = anyio.Event()
            with anyio.move_on_after(_DRIVING if robot.drives else _PARKED):
                await self._woken.wait()

    def command(self, command: str) -> None:
        """Give the robot a *command*."""
        self._command(command)
        self._woken.set()

    def header(self, frame: str) -> Header:
        """Return the header of a message in *frame*."""
        return Header(stamp=Time.from_seconds(self._clock.now()), frame_id=frame)

    def _battery_state(self, robot: Robot) -> Any:
        now = self._clock.monotonic()
        seconds, self._charged_at = now - self._charged_at, now
        is_docked = not robot.drives and robot.pose()[:2] == self.dock[:2]
        rate = _CHARGES if is_docked else -_DRAINS if robot.drives else 0.0
        self._charge = min(1.0, max(0.0, self._charge + rate * seconds))
        status = _DISCHARGING if not is_docked else _FULL if self._charge == 1.0 else _CHARGING
        stated = {"header": self.header("base_link"), "percentage": self._charge, "power_supply_status": status}
        return zero_message(self._battery_type).model_copy(update=_BATTERY | stated)

    def _transform(
        self, parent: str, child: str, x: float, y: float, z: float = 0.0, yaw: float = 0.0
    ) -> TransformStamped:
        transform = Transform(translation=Vector3(x=x, y=y, z=z), rotation=_turn_quaternion(yaw))
        return TransformStamped(header=self.header(parent), child_frame_id=child, transform=transform)


def ros_pose(pose: MapPose) -> Pose:
    """Return *pose* as a message."""
    return Pose(position=Point(x=pose.x, y=pose.y, z=0.0), orientation=_turn_quaternion(pose.yaw))


def _turn_quaternion(yaw: float) -> Quaternion:
    return Quaternion(x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2))


def _has_moved(before: MapPose, pose: MapPose) -> bool:
    turned = abs(math.remainder(pose.yaw - before.yaw, math.tau))
    return math.dist(before[:2], pose[:2]) >= _MOVED or turned >= _TURNED


def occupancy_grid(rooms: Rooms, stamp: Time) -> OccupancyGrid:
    """Return the map: rooms are free, walls except doors occupied, everything else unknown."""
    xs, ys = zip(*(corner for room in rooms.rooms.values() for corner in room.corners), strict=True)
    left, bottom = min(xs), min(ys)
    width = math.ceil((max(xs) - left) / _CELL) + 1
    height = math.ceil((max(ys) - bottom) / _CELL) + 1
    cells = bytearray([_UNKNOWN]) * (width * height)

    def fill(x1: float, y1: float, x2: float, y2: float, value: int) -> None:
        first, last = round((x1 - left) / _CELL), round((x2 - left) / _CELL) + 1
        for row in range(round((y1 - bottom) / _CELL), round((y2 - bottom) / _CELL) + 1):
            cells[row * width + first : row * width + last] = bytes([value]) * (last - first)

    for x1, y1, x2, y2 in _boxes(rooms):
        fill(x1, y1, x2, y2, _OCCUPIED)
    for x1, y1, x2, y2 in _boxes(rooms):
        fill(x1 + _CELL, y1 + _CELL, x2 - _CELL, y2 - _CELL, _FREE)
    for room, other, (x, y) in rooms.doorways():
        (left1, bottom1), (right1, top1) = rooms.rooms[room].corners[0], rooms.rooms[room].corners[2]
        is_upright = x in {left1, right1} and bottom1 < y < top1 and other != OUTSIDE
        dx, dy = (_CELL, DOOR_WIDTH / 2) if is_upright else (DOOR_WIDTH / 2, _CELL)
        fill(x - dx, y - dy, x + dx, y + dy, _FREE)
    origin = Pose(position=Point(x=left - _CELL / 2, y=bottom - _CELL / 2, z=0.0), orientation=Quaternion(w=1.0))
    info = MapMetaData(map_load_time=stamp, resolution=_CELL, width=width, height=height, origin=origin)
    return OccupancyGrid(header=Header(stamp=stamp, frame_id="map"), info=info, data=array("b", bytes(cells)))


def _boxes(rooms: Rooms) -> Iterator[tuple[float, float, float, float]]:
    for room in rooms.rooms.values():
        if room.corners:
            yield (*room.corners[0], *room.corners[2])
