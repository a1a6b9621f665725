"""The coordinate frames of all robots, and the poses in ``map`` that follow. Pure; the time is an argument."""

from __future__ import annotations

from collections.abc import Iterable
from math import isfinite
from typing import Final, final

from homebot.devices.robot_owners import MAP, RobotOwners
from homebot.messages.builtin_interfaces import Time
from homebot.messages.geometry_msgs import Pose, TransformStamped
from homebot.places.rigid import Rigid, yaw_of
from homebot.places.transforms import TransformBuffer, TransformException
from homebot.robots.evidence import MapPose

__all__ = ["MOST_AHEAD", "RobotFrames"]

MOST_AHEAD: Final = 5.0
"""Seconds by which a stamp may be ahead of our clock: AMCL states transforms a second ahead."""

_NORM_TOLERANCE: Final = 0.01
_BASES: Final = ("base_link", "base_footprint")


@final
class RobotFrames:
    """The frames that robots state.

    Args:
        owners: The robots, with their frames.
    """

    def __init__(self, owners: RobotOwners) -> None:
        self._owners = owners
        self._buffer = TransformBuffer()
        self._received: dict[str, float] = {}  # of frames that move, by the child

    def add(self, transform: TransformStamped, robot: str, now: float, stamp: float, *, is_static: bool) -> str:
        """Insert *transform*, stated in the namespace of *robot* or, with an empty one, of all robots.

        Args:
            now: The monotonic clock.
            stamp: Seconds since the Unix epoch, in place of a stamp of zero.

        Returns:
            The robot that has the frame.

        Raises:
            TransformException: It is refused; the message says why.
        """
        child = self.name_of(transform.child_frame_id, robot)
        parent = self.name_of(transform.header.frame_id, robot)
        owner = robot or self._owners.of_frame(child)
        if child == MAP or not owner:
            raise TransformException(f"the frame {child[:100]!r} is of no robot that may state it here")
        header = transform.header
        stated = header.stamp.to_seconds()
        if stated > stamp + MOST_AHEAD:
            raise TransformException(f"the transform of {child[:100]!r} is {stated - stamp:.0f} s ahead of our clock")
        if not stated or (parent, child) != (header.frame_id, transform.child_frame_id):
            at = header.stamp if stated else Time.from_seconds(stamp)
            header = header.model_copy(update={"frame_id": parent, "stamp": at})
            transform = transform.model_copy(update={"header": header, "child_frame_id": child})
        if is_static:
            self._buffer.set_transform_static(transform, owner)
            self._received.pop(child, None)
        elif self._buffer.set_transform(transform, owner):
            self._received[child] = now
        return owner

    def name_of(self, frame: str, robot: str) -> str:
        """Return the full name of *frame*, as stated in the namespace of *robot*."""
        frame = frame.removeprefix("/")
        is_full = not robot or frame in {"", MAP} or frame.startswith(f"{robot}/")
        return frame if is_full else f"{robot}/{frame}"

    def pose_of(self, robot: str, frames: Iterable[str] = ()) -> tuple[MapPose, float] | None:
        """Return the position of *robot* in ``map`` and when the oldest part of it was received; None without one.

        Args:
            frames: Frames of the robot that do not begin with its name.
        """
        plain = _BASES if robot == self._owners.sole else ()
        own = (one for one in frames if one.endswith(_BASES))
        for base in (*(f"{robot}/{one}" for one in _BASES), *own, *plain):
            chain = self._buffer.ancestors(base)
            received = [self._received[frame] for frame in chain[:-1] if frame in self._received]
            if chain[-1] != MAP or not received:
                continue
            try:
                found = self._buffer.lookup_transform(MAP, base)
            except TransformException:
                continue
            moved, turned = found.transform.translation, found.transform.rotation
            return MapPose(moved.x, moved.y, yaw_of((turned.x, turned.y, turned.z, turned.w))), min(received)
        return None

    def in_map(self, pose: Pose, frame: str) -> MapPose | None:
        """Return *pose*, stated in *frame*, in ``map``; None where no static transform joins the two."""
        point, turn = pose.position, pose.orientation
        norm = turn.x**2 + turn.y**2 + turn.z**2 + turn.w**2
        rotation = (turn.x, turn.y, turn.z, turn.w) if abs(norm - 1) < _NORM_TOLERANCE else (0.0, 0.0, 0.0, 1.0)
        rigid = Rigid((point.x, point.y, point.z), rotation)
        if not all(map(isfinite, rigid.translation)):
            return None
        if frame not in {"", MAP}:
            if any(one in self._received for one in self._buffer.ancestors(frame)):
                return None
            try:
                found = self._buffer.lookup_transform(MAP, frame).transform
            except TransformException:
                return None
            moved, turned = found.translation, found.rotation
            outer = Rigid((moved.x, moved.y, moved.z), (turned.x, turned.y, turned.z, turned.w))
            rigid = outer.then(rigid)
        x, y, _ = rigid.translation
        return MapPose(x, y, yaw_of(rigid.rotation))
