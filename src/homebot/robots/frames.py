"""The coordinate frames of all robots, and the resulting poses in ``map``. Pure; the time is an argument."""

from contextlib import suppress
from typing import Final, final

from homebot.devices.robot_owners import MAP, RobotOwners
from homebot.messages.geometry_msgs import Pose, TransformStamped
from homebot.places.rigid import MapPose, Rigid, yaw_of
from homebot.places.transforms import (
    MAX_FRAMES,
    NORM_TOLERANCE,
    InvalidArgumentException,
    LookupException,
    Sample,
    TransformBuffer,
    TransformException,
    rigid_of,
)
from homebot.robots.robot import TrackedRobot

_FARTHEST: Final = 1e6
"""The largest distance from the origin of the map, in metres."""

_BASES: Final = ("base_link", "base_footprint")


@final
class RobotFrames:
    """The frames of robots, each with the time of reception."""

    def __init__(self, owners: RobotOwners) -> None:
        self._owners = owners
        self._buffer = TransformBuffer()
        self._named: dict[str, set[str]] = {}
        self._most = MAX_FRAMES // max(1, len(owners.names))

    def add(self, transform: TransformStamped, robot: str, now: float, *, is_static: bool) -> str:
        """Insert *transform* from the namespace of *robot*, empty for all robots; return its owner."""
        child, parent = (self.name_of(frame, robot) for frame in (transform.child_frame_id, transform.header.frame_id))
        owner = robot or self._owners.of_frame(child)
        named = self._named.setdefault(owner, {MAP})
        if len(named) + len({parent, child} - named) > self._most:
            raise InvalidArgumentException(f"{child[:100]!r} is one more than the {self._most:,} frames of {owner}")
        sample = Sample(round(now * 1e9), parent, rigid_of(transform.transform))
        self._buffer.insert(child, sample, owner, is_static=is_static)
        named |= {parent, child}
        return owner

    def name_of(self, frame: str, robot: str) -> str:
        """Return the full name of *frame* in the namespace of *robot*."""
        frame = frame.removeprefix("/")
        is_full = not robot or frame in {"", MAP} or frame.startswith(f"{robot}/")
        return frame if is_full else f"{robot}/{frame}"

    def pose_of(self, robot: TrackedRobot) -> tuple[MapPose, float] | None:
        """Return the pose of *robot* in ``map``, and when its oldest component was received; None without one."""
        own = (frame for frame in robot.settings.frames if frame.endswith(_BASES))
        plain = _BASES if robot.name == self._owners.sole else ()
        for base in (*(f"{robot.name}/{suffix}" for suffix in _BASES), *own, *plain):
            with suppress(TransformException):
                transform = self._buffer.lookup_transform(MAP, base)
                at = _in_plane(rigid_of(transform.transform))
                received = transform.header.stamp.to_seconds()  # zero if all frames are static
                if received and _is_on_map(at):
                    return at, received
        return None

    def in_map(self, pose: Pose, frame: str) -> MapPose:
        """Transform *pose* from *frame* to ``map``.

        Raises:
            TransformException: No static transform connects the two, or the position is not on a map.
        """
        point, turn = pose.position, pose.orientation
        rotation = (turn.x, turn.y, turn.z, turn.w)
        if not abs(sum(component * component for component in rotation) - 1) < NORM_TOLERANCE:  # true for NaN too
            rotation = (0.0, 0.0, 0.0, 1.0)
        unknown = LookupException(f"no static transform connects its frame {frame[:100]!r} to map")
        try:
            transform = self._buffer.lookup_transform(MAP, frame or MAP)
        except TransformException as exc:
            raise unknown from exc
        if transform.header.stamp.to_seconds():
            raise unknown
        at = _in_plane(rigid_of(transform.transform).then(Rigid((point.x, point.y, point.z), rotation)))
        if not _is_on_map(at):
            raise InvalidArgumentException(
                f"its position ({at.x:g}, {at.y:g}) is not within {_FARTHEST:g} m of the map"
            )
        return at


def _in_plane(rigid: Rigid) -> MapPose:
    return MapPose(*rigid.translation[:2], yaw_of(rigid.rotation))


def _is_on_map(at: MapPose) -> bool:
    return all(abs(coordinate) <= _FARTHEST for coordinate in (at.x, at.y))  # false for NaN
