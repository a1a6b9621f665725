"""Facts that policies check a command against, and their verdicts. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable
from datetime import datetime, tzinfo
from typing import NamedTuple, TypeAlias

from homebot.control.policies.house import House
from homebot.control.policies.turns import Turns
from homebot.control.timeline.part_timeline import PartTimeline
from homebot.devices import Device, DevicePart

__all__ = ["Facts"]

TimelineOf: TypeAlias = Callable[[Device, DevicePart], PartTimeline]
"""Returns the timeline of a part."""


class Facts(NamedTuple):
    """A read-only view of the house at one moment.

    Attributes:
        now: Seconds since the Unix epoch.
        monotonic: Seconds of a clock that is never set.
        zone: The time zone of the home; None for that of the computer.
        house: The devices that the policies need.
        turns: The turns of values.
        timeline_of: The timeline of each part.
        clock_set_at: When the computer's clock was last set, or its sleep ended, by the monotonic clock.
    """

    now: float
    monotonic: float
    zone: tzinfo | None
    house: House
    turns: Turns
    timeline_of: TimelineOf
    clock_set_at: float = -math.inf

    def age(self, stamp: float) -> float:
        """Return the seconds since *stamp*, at most those since the clock was set."""
        since_set = self.monotonic - self.clock_set_at
        if stamp > self.now:
            return since_set if since_set < math.inf else 0.0
        return min(self.now - stamp, since_set)

    @property
    def local_time(self) -> datetime:
        """The time in the home."""
        return datetime.fromtimestamp(self.now, self.zone)
