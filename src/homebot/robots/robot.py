"""One robot: the evidence of where it is, and the best of it. Pure; the time is an argument."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final, NamedTuple, final

from homebot.places.rigid import MapPose
from homebot.robots.settings import RobotSettings

__all__ = ["MOTION_LIMIT", "TAG_LIMIT", "PoseEvidence", "TrackedRobot"]

MOTION_LIMIT: Final = 60.0
TAG_LIMIT: Final = 600.0
"""Seconds for which a room counts, by a motion sensor, and by a tag or the robot's own word."""

ROOM_ERROR: Final = 4.0
"""Metres by which a position may be wrong where only the room is known."""

_LOST_SIGMA: Final = 1.0
"""Standard deviation in metres above which localization does not know where it is."""

_FASTEST: Final = 2.0
_STEP: Final = 0.7
"""Metres, beside three standard deviations and the way of the fastest robot, by which a pose may jump."""

_CONSISTENT: Final = 3
_MOST_SOURCES: Final = 100


class PoseEvidence(NamedTuple):
    """A statement about where a robot is.

    Attributes:
        source: The topic, sensor or tag reader that it is from.
        received_at: When, on the monotonic clock.
        limit: Seconds for which it counts; 0 where something showed that it no longer holds.
        error: Metres by which it may be wrong.
        position: The position; None where only the room is known.
        room: The room, where it is stated.
        floor: The floor; empty where that is not stated.
        is_nearest_room: Whether the stated room is only the nearest.
        by_life: Whether *limit* counts from the robot's last sign of life: a parked robot repeats no pose.
        covariance: The 36 numbers of a ROS pose; empty where they are not stated.
    """

    source: str
    received_at: float
    limit: float
    error: float = ROOM_ERROR
    position: MapPose | None = None
    room: str = ""
    floor: str = ""
    is_nearest_room: bool = False
    by_life: bool = False
    covariance: Sequence[float] = ()

    @property
    def sigma(self) -> float:
        """The standard deviation of the position, in metres; 0 where that is not stated."""
        return math.sqrt(max(self.covariance[0], self.covariance[7], 0.0)) if self.covariance else 0.0


@final
class TrackedRobot:
    """The evidence of where one robot is, by its source.

    Args:
        name: The name of the robot.
        settings: Its table.
        on_change: Called after each change.

    Attributes:
        name: Likewise.
        settings: Likewise.
        alive_at: When it last gave a sign of life, on the monotonic clock.
        unsure_because: Why the robot does not know where it is; empty if it does.
        covariance: That of its position, as it stated it last.
    """

    def __init__(self, name: str, settings: RobotSettings, on_change: Callable[[], None]) -> None:
        self.name = name
        self.settings = settings
        self.alive_at = -math.inf
        self.unsure_because = ""
        self.covariance: Sequence[float] = ()
        self._on_change = on_change
        self._by_source: dict[str, PoseEvidence] = {}
        self._consistent = 0

    def add(self, evidence: PoseEvidence) -> None:
        """Take *evidence* in place of the last of its source, and check whether the robot was carried away."""
        before = self._by_source.pop(evidence.source, None)
        self._by_source[evidence.source] = evidence
        if len(self._by_source) > _MOST_SOURCES:  # tags, of which there may be many
            del self._by_source[next(iter(self._by_source))]
        self.add_life(evidence.received_at)
        if evidence.position is None:
            return
        if evidence.sigma > _LOST_SIGMA:
            self.make_unsure(f"its localization is uncertain by {evidence.sigma:.1f} m")
        elif before is not None and (jump := _jump(before, evidence)):
            self.make_unsure(f"{evidence.source} jumped by {jump:.1f} m")
        elif self.unsure_because:
            self._consistent += 1
            if self._consistent >= _CONSISTENT:
                self.unsure_because = ""

    def add_life(self, at: float) -> None:
        """Take a message of the robot as a sign that it lived *at* that time."""
        self.alive_at = max(self.alive_at, at)
        self._on_change()

    def make_unsure(self, reason: str) -> None:
        """Doubt the robot's poses until three in a row are consistent."""
        self.unsure_because = reason
        self._consistent = 0
        self._on_change()

    def drop(self, source: str) -> None:
        """End the evidence of *source*: it counts no longer."""
        if (known := self._by_source.get(source)) is not None:
            self._by_source[source] = known._replace(limit=0.0, by_life=False)
            self._on_change()

    def last_of(self, source: str) -> PoseEvidence | None:
        """Return the last evidence of *source*."""
        return self._by_source.get(source)

    def best(self, now: float) -> PoseEvidence | None:
        """Return the evidence of the smallest error that counts, else the last that did; None without any."""
        counting = [one for one in self._by_source.values() if self.expires_at(one) > now]
        if counting:
            return min(counting, key=lambda one: (one.error, one.source))
        return max(self._by_source.values(), key=self.expires_at, default=None)

    def expires_at(self, evidence: PoseEvidence) -> float:
        """Return when *evidence* no longer counts, on the monotonic clock."""
        begin = max(evidence.received_at, self.alive_at) if evidence.by_life else evidence.received_at
        return begin + evidence.limit

    def next_change(self, now: float) -> float:
        """Return when :meth:`best` changes without further evidence; infinite for never."""
        ends = map(self.expires_at, self._by_source.values())
        return min((end for end in ends if end > now), default=math.inf)


def _jump(before: PoseEvidence, after: PoseEvidence) -> float:
    """Return metres from one position of a source to the next if no robot drives so far; otherwise 0."""
    if before.position is None or after.position is None:
        return 0.0
    step = math.dist(before.position[:2], after.position[:2])
    seconds = max(0.0, after.received_at - before.received_at)
    return step if step > _FASTEST * seconds + 3 * max(before.sigma, after.sigma) + _STEP else 0.0
