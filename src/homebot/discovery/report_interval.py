"""The intervals between the reports of a device, and its usual silence. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

_KEPT = 8

_BURST = 1.0
"""Seconds within which messages belong together, as devices often send several at once."""

_MIN_GAPS = 3

_SILENCE_FACTOR = 3.0
"""Usual gaps that silence may last: two reports may be lost on the way."""

_MAX_OF_FEW = 86_400.0

_MAX_INTERVAL_S = 7 * 86_400.0


@final
@dataclass(slots=True, eq=False)
class ReportInterval:
    """The gaps between the last reports of a device: at most eight, so that old habits are forgotten.

    From three gaps on the longest one is ignored, as it may have been a power cut.

    Attributes:
        gaps: The gaps in seconds, oldest first.
        expected_silence: Seconds of silence that are usual after a report; 0 if unknown.
    """

    gaps: tuple[float, ...] = ()
    expected_silence: float = 0.0
    _last: float | None = None

    @classmethod
    def of(cls, gaps: Iterable[float]) -> ReportInterval:
        """Return the interval that these *gaps* of an earlier run show."""
        known = tuple(gaps)[-_KEPT:]
        return cls(known, _usual_silence(known))

    def record(self, now: float) -> float:
        """Record a report at *now*, in seconds; return the expected silence after it."""
        last = self._last
        if last is None:
            self._last = now
        elif (gap := now - last) >= _BURST:
            self._last = now
            self._learn((*self.gaps, gap)[-_KEPT:])
        return self.expected_silence

    def join(self, other: ReportInterval) -> None:
        """Copy the interval that *other* has learnt about the same device, if it is longer."""
        if len(other.gaps) > len(self.gaps):
            self._learn(other.gaps)
        if other._last is not None:
            self._last = max(other._last, self._last or other._last)

    def _learn(self, gaps: tuple[float, ...]) -> None:
        self.gaps = gaps
        self.expected_silence = _usual_silence(gaps)


def _usual_silence(gaps: tuple[float, ...]) -> float:
    if not gaps:
        return 0.0
    if len(gaps) < _MIN_GAPS:
        return min(_SILENCE_FACTOR * min(gaps), _MAX_OF_FEW)
    return min(_SILENCE_FACTOR * sorted(gaps)[-2], _MAX_INTERVAL_S)
