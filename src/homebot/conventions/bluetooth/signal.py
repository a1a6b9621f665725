"""Signals of Bluetooth devices: a coarse distance by their strength, and the usual interval between them. Pure.

The model of distances is the path loss that grows with the logarithm of the distance: ``d = 10 ** ((P1 - P) / (10 n))``
metres, where P is received and P1 is the reference at one metre. In a dwelling, at about 2 GHz, 10 n is 28, and walls
scatter the loss by 8 dB (Recommendation ITU-R P.1238, tables of power loss coefficients and of shadow fading,
residential), so that the true distance is within the estimate times and divided by ``10 ** (8 / 28)``, about 2, two
times out of three. A median over some seconds removes fading, which changes from packet to packet, but not this.
"""

from collections import deque
from statistics import median

RSSI_AT_1M = -59.0
"""Signal strength of most small devices at one metre, in dBm."""

LOSS_PER_DECADE = 28.0
SCATTER = 8.0
"""Both in dB."""

DISTANCE_FACTOR = 10 ** (SCATTER / LOSS_PER_DECADE)

KEPT = 15
KEPT_FOR = 30.0
_WEAKEST, _STRONGEST = -127, 20
_NEAREST, _FARTHEST = 0.1, 100.0


def distance_of(rssi: float, rssi_at_1m: float) -> float:
    """Return a distance in metres, 0.1 to 100, rounded to two significant digits; the strengths are in dBm."""
    metres = 10 ** ((rssi_at_1m - rssi) / LOSS_PER_DECADE)
    return float(f"{min(max(metres, _NEAREST), _FARTHEST):.2g}")


class SignalFilter:
    """The median of the last signal strengths of one device: at most 15, of the last 30 seconds."""

    def __init__(self) -> None:
        self._kept: deque[tuple[float, int]] = deque(maxlen=KEPT)

    def add(self, rssi: int, now: float) -> None:
        """Add a signal strength in dBm; invalid ones are ignored: 127 is unknown (Core 6.0, Vol 4, E 7.7.65.2)."""
        if _WEAKEST < rssi <= _STRONGEST:
            self._kept.append((now, rssi))

    def value(self, now: float) -> float | None:
        """Return the median; None if nothing was received lately."""
        while self._kept and now - self._kept[0][0] > KEPT_FOR:
            self._kept.popleft()
        return float(median(rssi for _, rssi in self._kept)) if self._kept else None


SHORTEST = 30.0
"""Seconds of silence that mean nothing: advertisements get lost, and BlueZ only reports changed ones."""

INTERVALS = 3
_KEPT_GAPS = 8
_STEPS = (SHORTEST, 60.0, 120.0, 300.0, 600.0, 1800.0, 3600.0, 21_600.0, 86_400.0)
_APART = 1.0


class Presence:
    """The times of a device's first and last advertisement, by the gateway's clock, and its usual interval."""

    def __init__(self, now: float) -> None:
        self.first_heard = now
        self.last_heard = now
        self._counted_at = now
        self._gaps: deque[float] = deque(maxlen=_KEPT_GAPS)

    def record(self, now: float) -> None:
        """Count an advertisement; copies of one packet, within a second, count once."""
        self.last_heard = now
        if now - self._counted_at >= _APART:
            self._gaps.append(now - self._counted_at)
            self._counted_at = now

    def stale_after(self, silence: float) -> float:
        """Return three times its interval, or at least *silence*, in few steps so that it seldom changes.

        The interval is the second longest of the last eight, so that one absence does not count.
        """
        longest = sorted(self._gaps)[-2:]
        wanted = max(silence, INTERVALS * (longest[0] if longest else 0.0))
        return next((step for step in _STEPS if step >= wanted), max(_STEPS[-1], silence))
