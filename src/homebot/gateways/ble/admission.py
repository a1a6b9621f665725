"""Limits how many new devices are accepted, and how fast: anybody can advertise under any address. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.gateways.ble.known_device import KnownDevice
from homebot.rate_limit import RateLimit

__all__ = ["Newcomers", "find_dispensable"]

BURST = 200
RATE = 5.0
"""Devices a second; a house has fewer than the burst, so that more are probably fake."""

SETTLED_AFTER = 60.0
"""Seconds after which a device is not removed to make room for another."""


class Newcomers:
    """The rate limit for new devices: 200 at once, then five a second."""

    def __init__(self) -> None:
        self.refused = 0
        self._limit = RateLimit(RATE, BURST)

    def admits(self, now: float) -> bool:
        """Return whether one more device may be accepted now."""
        is_admitted = self._limit.admits(now)
        self.refused += not is_admitted
        return is_admitted


def find_dispensable(devices: Iterable[KnownDevice]) -> KnownDevice | None:
    """Return the longest silent device of those heard for less than a minute; None if there is none."""
    brief = (one for one in devices if one.presence.last_heard - one.presence.first_heard < SETTLED_AFTER)
    return min(brief, key=lambda one: one.presence.last_heard, default=None)
