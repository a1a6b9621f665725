"""The coordinate frames of all robots, and the poses in ``map`` that follow. Pure; the time is an argument."""

from __future__ import annotations

from contextlib import suppress
from math import isfinite
from typing import Final, final

from homebot.devices.robot_owners import MAP, RobotOwners
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Pose, TransformStamped
from homebot.places.rigid import MapPose, Rigid, yaw_of
from homebot.places.transforms import TransformBuffer, TransformException, rigid_of
from homebot.robots.robot import TrackedRobot

__all__ = ["RobotFrames"]

_NORM_TOLERANCE: Final = 0.01
_BASES: Final = ("base_link", "base_footprint")


@final
class RobotFrames:
    """The frames that robots state, each at the time when it was received.

    Args:
        owners: The robots, with their frames.
    """

    def __init__(self, owners: RobotOwners) -> None:
        self._owners = owners
        self._buffer = TransformBuffer()

    def add(self, transform: TransformStamped, robot: str, now: float, *, is_static: bool) -> str:
        """Insert *transform*, which came in the namespace of *robot*, empty for that of all; return whose it is.

        Raises:
            TransformException: It is refused; the message says why.
        """
        header, child = transform.header, self.name_of(transform.child_frame_id, robot)
        owner = robot or self._owners.of_frame(child)
        parent = self.name_of(header.frame_id, robot)
        header = header.model_copy(update={"frame_id": parent, "stamp": Time.from_seconds(now)})
        insert = self._buffer.set_transform_static if is_static else self._buffer.set_transform
        insert(transform.model_copy(update={"header": header, "child_frame_id": child}), owner)
        return owner

    def name_of(self, frame: str, robot: str) -> str:
        """Return the full name of *frame*, as stated in the namespace of *robot*."""
        frame = frame.removeprefix("/")
        is_full = not robot or frame in {"", MAP} or frame.startswith(f"{robot}/")
        return frame if is_full else f"{robot}/{frame}"

    def pose_of(self, robot: TrackedRobot) -> tuple[MapPose, float] | None:
        """Return the position of *robot* in ``map`` and when the oldest part of it was received; None without one."""
        own = (one for one in robot.settings.frames if one.endswith(_BASES))
        plain = _BASES if robot.name == self._owners.sole else ()
        for base in (*(f"{robot.name}/{one}" for one in _BASES), *own, *plain):
            with suppress(TransformException):
                found = self._buffer.lookup_transform(MAP, base)
                if received := found.header.stamp.to_seconds():  # of static frames alone it is zero
                    return _in_plane(rigid_of(found.transform)), received
        return None

    def in_map(self, pose: Pose, frame: str) -> MapPose | None:
        """Return *pose*, stated in *frame*, in ``map``; None where no static transform joins the two."""
        point, turn = pose.position, pose.orientation
        norm = turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2
        rotation = (turn.x, turn.y, turn.z, turn.w) if abs(norm - 1) < _NORM_TOLERANCE else (0.0, 0.0, 0.0, 1.0)
        with suppress(TransformException):
            found = self._buffer.lookup_transform(MAP, frame or MAP)
            at = _in_plane(rigid_of(found.transform).then(Rigid((point.x, point.y, point.z), rotation)))
            return at if isfinite(at.x) and isfinite(at.y) and not found.header.stamp.to_seconds() else None
        return None


def _in_plane(rigid: Rigid) -> MapPose:
    return MapPose(*rigid.translation[:2], yaw_of(rigid.rotation))
