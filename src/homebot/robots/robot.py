"""One robot: the evidence of where it is, and the best of it. Pure; the time is an argument."""

from __future__ import annotations

import math
from typing import Final, final

from homebot.robots.evidence import LOST_SIGMA, PoseEvidence

__all__ = ["TrackedRobot"]

_HYSTERESIS: Final = 2.0
"""Seconds for which other evidence has to be better before it replaces evidence that still counts."""

_FASTEST: Final = 2.0
_STEP: Final = 0.5
"""Metres, beside three standard deviations and the way of the fastest robot, by which a pose may jump."""

_CONSISTENT: Final = 3


@final
class TrackedRobot:
    """The evidence of where one robot is, by its source.

    Args:
        name: The name of the robot.

    Attributes:
        alive_at: When it last gave a sign of life, on the monotonic clock.
        unsure_because: Why the robot does not know where it is; empty if it does.
        sigma: The standard deviation of its position that it stated last, in metres; None if it stated none.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.alive_at = -math.inf
        self.unsure_because = ""
        self.sigma: float | None = None
        self._by_source: dict[str, PoseEvidence] = {}
        self._current: PoseEvidence | None = None
        self._better_since: float | None = None
        self._consistent = 0

    def add(self, evidence: PoseEvidence) -> None:
        """Take *evidence* in place of the last of its source, and check whether the robot was carried away."""
        before = self._by_source.get(evidence.source)
        self._by_source[evidence.source] = evidence
        self.alive_at = max(self.alive_at, evidence.received_at)
        if self._current is not None and self._current.source == evidence.source:
            self._current = evidence
        if evidence.position is None:
            return
        if evidence.by_life:
            self.sigma = evidence.sigma
        if evidence.sigma > LOST_SIGMA:
            self.make_unsure(f"its localization is uncertain by {evidence.sigma:.1f} m")
        elif before is not None and before.position is not None and (jump := _jump(before, evidence)):
            self.make_unsure(f"{evidence.source} jumped by {jump:.1f} m")
        elif self.unsure_because:
            self._consistent += 1
            if self._consistent >= _CONSISTENT:
                self.unsure_because = ""

    def make_unsure(self, reason: str) -> None:
        """Doubt the robot's poses until three in a row are consistent."""
        self.unsure_because = reason
        self._consistent = 0

    def drop(self, source: str) -> None:
        """End the evidence of *source*: it counts no longer."""
        if (known := self._by_source.get(source)) is not None:
            self._by_source[source] = ended = known._replace(has_ended=True)
            if self._current is known:
                self._current = ended

    def last_of(self, source: str) -> PoseEvidence | None:
        """Return the last evidence of *source*."""
        return self._by_source.get(source)

    def best(self, now: float) -> PoseEvidence | None:
        """Return the evidence of the smallest error that counts, else the last that did; None without any.

        While the present one counts, a better one replaces it only after 2 s.
        """
        counting = [one for one in self._by_source.values() if one.expires_at(self.alive_at) > now]
        if not counting:
            self._better_since = None
            return self._current
        best = min(counting, key=lambda one: (one.error, -one.received_at))
        present = self._current
        if present is None or present.expires_at(self.alive_at) <= now:
            self._current = best
        elif best.error < present.error and best.source != present.source:
            if self._better_since is None:
                self._better_since = now
            if now - self._better_since < _HYSTERESIS:
                return present
            self._current = best
        self._better_since = None
        return self._current

    def next_change(self, now: float) -> float:
        """Return when :meth:`best` changes without further evidence; infinite for never."""
        ends = [end for one in self._by_source.values() if (end := one.expires_at(self.alive_at)) > now]
        if self._better_since is not None:
            ends.append(self._better_since + _HYSTERESIS)
        return min(ends, default=math.inf)


def _jump(before: PoseEvidence, after: PoseEvidence) -> float:
    """Return metres from one position of a source to the next if no robot drives so far; otherwise 0."""
    first, last = before.position, after.position
    if first is None or last is None:
        return 0.0
    step = math.dist((first.x, first.y), (last.x, last.y))
    seconds = max(0.0, after.received_at - before.received_at)
    return step if step > _FASTEST * seconds + 3 * max(before.sigma, after.sigma) + _STEP else 0.0
