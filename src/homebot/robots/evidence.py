"""Evidence of where a robot is, and how long each kind of it counts. Pure."""

from __future__ import annotations

import math
from typing import Final, NamedTuple

__all__ = [
    "AMCL_LIMIT",
    "LOST_SIGMA",
    "MOTION_LIMIT",
    "ODOMETRY_MOVED",
    "ROOM_ERROR",
    "TAG_LIMIT",
    "TF_LIMIT",
    "MapPose",
    "PoseEvidence",
]

TF_LIMIT: Final = 2.0
AMCL_LIMIT: Final = 10.0
MOTION_LIMIT: Final = 60.0
TAG_LIMIT: Final = 600.0
"""Seconds for which evidence of each kind counts."""

ODOMETRY_MOVED: Final = 0.25
"""Metres of odometry after which a pose of ``/amcl_pose`` no longer counts: AMCL publishes the next one by then."""

LOST_SIGMA: Final = 1.0
"""Standard deviation in metres above which localization does not know where it is."""

ROOM_ERROR: Final = 4.0
"""Metres by which a position may be wrong where only the room is known."""


class MapPose(NamedTuple):
    """A position in the frame ``map``.

    Attributes:
        x: Metres.
        y: Metres.
        yaw: Radians from the x axis, counter-clockwise.
    """

    x: float
    y: float
    yaw: float = 0.0


class PoseEvidence(NamedTuple):
    """A statement about where a robot is.

    Attributes:
        source: The topic, device or tag that it is from.
        received_at: When, on the monotonic clock.
        limit: Seconds for which it counts.
        error: Metres by which it may be wrong.
        position: The position; None where only the room is known.
        room: The room, where it is stated.
        floor: The floor; empty where that is not stated.
        is_nearest_room: Whether the stated room is only the nearest.
        by_life: Whether *limit* counts from the robot's last sign of life: a parked robot repeats no pose.
        sigma: The standard deviation of the position that the robot states, in metres.
        has_ended: Whether something showed that it no longer holds.
    """

    source: str
    received_at: float
    limit: float
    error: float
    position: MapPose | None = None
    room: str = ""
    floor: str = ""
    is_nearest_room: bool = False
    by_life: bool = False
    sigma: float = 0.0
    has_ended: bool = False

    def expires_at(self, alive_at: float) -> float:
        """Return when it no longer counts, on the monotonic clock, by the robot's last sign of life."""
        if self.has_ended:
            return -math.inf
        return (max(self.received_at, alive_at) if self.by_life else self.received_at) + self.limit
