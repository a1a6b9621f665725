"""Limits how many new devices are accepted, and how fast: anybody can advertise under any address. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.gateways.ble.known_device import KnownDevice

__all__ = ["Newcomers", "find_dispensable"]

BURST = 200
RATE = 5.0
"""Devices a second; a house has fewer than the burst, so that more are probably fake."""

SETTLED_AFTER = 60.0
"""Seconds after which a device is not removed to make room for another."""


class Newcomers:
    """The rate limit for new devices: 200 at once, then five a second."""

    def __init__(self, now: float) -> None:
        self.refused = 0
        self._left = float(BURST)
        self._at = now

    def admits(self, now: float) -> bool:
        """Return whether one more device may be accepted now."""
        self._left = min(float(BURST), self._left + (now - self._at) * RATE)
        self._at = now
        if self._left < 1:
            self.refused += 1
            return False
        self._left -= 1
        return True


def find_dispensable(devices: Iterable[KnownDevice]) -> KnownDevice | None:
    """Return the longest silent device of those heard for less than a minute; None if there is none."""
    brief = (one for one in devices if one.presence.last_heard - one.presence.first_heard < SETTLED_AFTER)
    return min(brief, key=lambda one: one.presence.last_heard, default=None)
