"""The facts that policies judge by. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, tzinfo

from homebot.control.policies.house import House
from homebot.control.policies.recent_commands import RecentCommands

__all__ = ["Facts"]


@dataclass(frozen=True, slots=True)
class Facts:
    """A read-only view of the house at one moment.

    Attributes:
        now: The time, in seconds since the Unix epoch.
        monotonic: The same by a clock that is never set, in seconds since an arbitrary start.
        zone: The time zone of the home; None for that of the computer.
        house: The devices that some policy needs.
        recent: The commands that were sent lately.
    """

    now: float
    monotonic: float
    zone: tzinfo | None
    house: House
    recent: RecentCommands

    @property
    def local_time(self) -> datetime:
        """The time in the home."""
        return datetime.fromtimestamp(self.now, self.zone)
