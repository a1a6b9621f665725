"""One robot: the poses from its sources, and the best of them. Pure."""

import math
from collections.abc import Callable
from typing import Final, final

from homebot.devices.robot_messages import WAY_LIMIT_S, RobotPose
from homebot.messages.builtin_interfaces import Time
from homebot.places.plan import Point
from homebot.places.rigid import MapPose
from homebot.robots.settings import RobotSettings
from homebot.support.bounded_map import BoundedMap

MOTION_LIMIT: Final = 60.0
TAG_LIMIT: Final = 600.0
"""Seconds for which a room is valid: from a motion sensor, and from a tag or the robot itself."""

_ROOM_ERROR: Final = 4.0
"""The error of a position in metres if only the room is known."""

_LOST_SIGMA: Final = 1.0
"""The standard deviation in metres above which localization is considered lost."""

_FASTEST: Final = 2.0
_STEP: Final = 0.7
"""Metres by which a pose may jump, in addition to three times its error and the way of the fastest robot."""

_PARKED: Final = 0.25
"""Metres, besides three times its error, by which another source may differ from the last AMCL pose at rest."""

_MOVED: Final = 0.1
"""Metres by which a robot that stands is stated to move at most."""

_ARRIVED: Final = 0.5
"""Metres from the end of its way at which a robot has arrived; Nav2 stops within 0.25."""

_AMCL: Final = "/amcl_pose"
_CONSISTENT: Final = 3
_MAX_SOURCES: Final = 100


@final
class TrackedRobot:
    """The poses of one robot from all its sources.

    Args:
        now: Returns seconds since the Unix epoch, by a clock that never jumps.

    Attributes:
        alive_at: The time of its last sign of life.
        unsure_because: Why the robot does not know where it is; empty if it does.
        sigma: The last stated standard deviation of its position, in metres; None if unknown.
    """

    def __init__(
        self, name: str, settings: RobotSettings, now: Callable[[], float], on_change: Callable[[], None]
    ) -> None:
        self.name, self.settings, self.now, self._on_change = name, settings, now, on_change
        self.alive_at = -math.inf
        self.unsure_because = ""
        self._doubted_at = 0.0
        self.sigma: float | None = None
        self._poses: BoundedMap[str, RobotPose] = BoundedMap(_MAX_SOURCES)  # there may be many tags
        self._consistent = 0
        self._is_parked = True
        self._goal: Point | str | None = None
        self._under_way_at = -math.inf
        self._stood = (math.inf, math.inf)

    def place(
        self,
        source: str,
        limit: float,
        at: MapPose | None = None,
        *,
        age: float = 0.0,
        by_robot: bool = True,
        **place: object,
    ) -> None:
        """Replace the last pose from *source*, and check whether the robot was carried away.

        Args:
            limit: Seconds for which it is valid; for ``/amcl_pose`` counted from the last sign of life, unless a later
                    position of another source shows that the robot is elsewhere.
            age: Seconds since it was received.
            by_robot: Whether the robot itself states it, which is a sign of life.
            place: Further fields of the pose: ``error``, ``room``, ``floor``, ``is_nearest_room``.
        """
        values: dict[str, object] = {"robot": self.name, "source": source, "limit": limit, "error": _ROOM_ERROR}
        values |= place | {"received_at": Time.from_seconds(self.now() - age)}
        if at is not None:
            values.update(has_position=True, x=at.x, y=at.y, yaw=at.yaw)
            if not math.dist(at[:2], self._stood) <= _MOVED:
                self._stood, self._under_way_at = at[:2], self.now() - age
        before, pose = self._poses.get(source), RobotPose.model_validate(values)
        self._poses[source] = pose
        if source.endswith(_AMCL):
            self._is_parked = True
        elif any(other.source.endswith(_AMCL) and _is_apart(other, pose) for other in self._poses.values()):
            self._is_parked = False
        if before is not None and (jump := _jump(before, pose)):
            self.doubt(f"{source} jumped by {jump:.1f} m")
        elif self.unsure_because and pose.has_position:
            self._consistent += 1
            if self._consistent >= _CONSISTENT:
                self.unsure_because = ""
        if by_robot:
            self.add_life(age)
        else:
            self._on_change()

    @property
    def has_lived(self) -> bool:
        """True after its first sign of life."""
        return self.alive_at > -math.inf

    def add_life(self, age: float = 0.0) -> None:
        """Record a sign of life of the robot *age* seconds ago."""
        self.alive_at = max(self.alive_at, self.now() - age)
        self._on_change()

    def head_for(self, goal: Point | str | None) -> None:
        """Record that the robot is on its way to a point in the frame ``map``, or to a room; None for no longer."""
        self._goal, self._under_way_at = goal, self.now()
        self._on_change()

    def goal(self) -> Point | str | None:
        """Return the point or room that it drives to; None if it has arrived, or neither plans nor moves any more."""
        if self._goal is None or self.now() >= self._under_way_at + WAY_LIMIT_S:
            return None
        best = self.best()
        if best is None or not best.has_position or isinstance(self._goal, str):
            return self._goal
        return self._goal if math.dist((best.x, best.y), self._goal) > _ARRIVED else None

    def state_sigma(self, sigma: float) -> None:
        """Record the standard deviation of its position, in metres."""
        self.sigma = sigma
        if sigma > _LOST_SIGMA:
            self.doubt(f"its localization is uncertain by {sigma:.1f} m")

    def doubt(self, reason: str) -> None:
        """Distrust the robot's poses until three in a row are consistent, but not rooms stated from now on."""
        self.unsure_because, self._consistent, self._doubted_at = reason, 0, self.now()
        self._on_change()

    def drop(self, source: str) -> None:
        """Invalidate the pose of *source*."""
        if (known := self._poses.get(source)) is not None:
            self._poses[source] = known.model_copy(update={"limit": 0.0})
            self._on_change()

    def best(self) -> RobotPose | None:
        """Return the valid pose with the smallest error, preferring sure ones, else the last; None without any."""
        now = self.now()
        if counting := [pose for pose in self._poses.values() if self.expires_at(pose) > now]:
            return min(counting, key=lambda one: (not self.is_sure(one), one.error, one.source))
        return max(self._poses.values(), key=self.expires_at, default=None)

    def is_sure(self, pose: RobotPose) -> bool:
        """Return whether nothing makes *pose* doubtful."""
        is_newer_room = not pose.has_position and pose.received_at.to_seconds() >= self._doubted_at
        return not self.unsure_because or is_newer_room

    def expires_at(self, pose: RobotPose) -> float:
        """Return when *pose* becomes invalid."""
        at = pose.received_at.to_seconds()
        is_parked = pose.limit and self._is_parked and pose.source.endswith(_AMCL)
        return pose.limit + (max(at, self.alive_at) if is_parked else at)

    def next_change(self) -> float:
        """Return the seconds until :meth:`best` or :meth:`goal` changes by itself; infinite for never."""
        now, way = self.now(), () if self._goal is None else (self._under_way_at + WAY_LIMIT_S,)
        ends = (*map(self.expires_at, self._poses.values()), *way)
        return min((end - now for end in ends if end > now), default=math.inf)


def _is_apart(parked: RobotPose, pose: RobotPose) -> bool:
    """Return whether *pose* shows that the robot is no longer where it was *parked*."""
    metres = math.dist((parked.x, parked.y), (pose.x, pose.y)) if pose.has_position else 0.0
    return metres > _PARKED + 3 * max(parked.error, pose.error)


def _jump(before: RobotPose, after: RobotPose) -> float:
    """Return the distance between two positions of a source if no robot can drive that far; otherwise 0."""
    step = math.dist((before.x, before.y), (after.x, after.y)) if before.has_position and after.has_position else 0.0
    seconds = max(0.0, after.received_at.to_seconds() - before.received_at.to_seconds())
    return step if step > _FASTEST * seconds + 3 * max(before.error, after.error) + _STEP else 0.0
