"""The time that a Bluetooth device may be silent before it counts as stale. Pure."""

from __future__ import annotations

from collections import deque

__all__ = ["Presence"]

SHORTEST = 30.0
"""Seconds of silence that mean nothing: advertisements get lost, and BlueZ only tells of those that differ."""

INTERVALS = 3
_KEPT = 8
_STEPS = (SHORTEST, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 21_600.0, 86_400.0)
_APART = 1.0


class Presence:
    """The times at which a device was heard, and its usual interval.

    Attributes:
        first_heard: Seconds of the gateway's clock.
        last_heard: Likewise.
    """

    def __init__(self, now: float) -> None:
        self.first_heard = now
        self.last_heard = now
        self._counted_at = now
        self._gaps: deque[float] = deque(maxlen=_KEPT)

    def hear(self, now: float) -> None:
        """Count an advertisement; copies of one packet, within a second, count once."""
        self.last_heard = now
        if now - self._counted_at >= _APART:
            self._gaps.append(now - self._counted_at)
            self._counted_at = now

    def stale_after(self, silence: float) -> float:
        """Return three times the interval at which it is heard, or more, in few steps so that it seldom changes.

        The interval is the second longest of the last eight, so that one absence does not count.

        Args:
            silence: Seconds for which it may be silent at least.
        """
        longest = sorted(self._gaps)[-2:]
        wanted = max(silence, INTERVALS * (longest[0] if longest else 0.0))
        return next((one for one in _STEPS if one >= wanted), max(_STEPS[-1], silence))
