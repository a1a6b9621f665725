"""The facts that policies judge by. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import datetime, tzinfo

from homebot.control.policies.house import House

__all__ = ["Facts"]


@dataclass(frozen=True, slots=True)
class Facts:
    """A read-only view of the house at one moment.

    Attributes:
        now: The time, in seconds since the Unix epoch.
        zone: The time zone of the home; None for that of the computer.
        house: The devices that some policy needs.
    """

    now: float
    zone: tzinfo | None
    house: House

    @property
    def local_time(self) -> datetime:
        """The time in the home."""
        return datetime.fromtimestamp(self.now, self.zone)
