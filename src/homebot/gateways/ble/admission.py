"""Bounds how many devices become known, and how fast: anybody can send advertisements under any address. Pure."""

from __future__ import annotations

from collections.abc import Iterable

from homebot.gateways.ble.known_device import KnownDevice

__all__ = ["Newcomers", "find_dispensable"]

BURST = 200
RATE = 5.0
"""Devices a second; a house has fewer than the burst, and more come only where somebody makes them up."""

SETTLED_AFTER = 60.0
"""Seconds for which a device has been heard that is not given up for another."""


class Newcomers:
    """The pace at which devices become known: 200 at once, then five a second."""

    def __init__(self, now: float) -> None:
        self.refused = 0
        self._left = float(BURST)
        self._at = now

    def admits(self, now: float) -> bool:
        """Return whether one more may become known now."""
        self._left = min(float(BURST), self._left + (now - self._at) * RATE)
        self._at = now
        if self._left < 1:
            self.refused += 1
            return False
        self._left -= 1
        return True


def find_dispensable(devices: Iterable[KnownDevice]) -> KnownDevice | None:
    """Return the device that has been silent longest of those that were heard for less than a minute; None for none."""
    brief = (one for one in devices if one.presence.last_heard - one.presence.first_heard < SETTLED_AFTER)
    return min(brief, key=lambda one: one.presence.last_heard, default=None)
