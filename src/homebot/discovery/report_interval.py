"""Intervals between the reports of a device, and the silence that is usual for it. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

__all__ = ["ReportInterval"]

_KEPT = 8

_BURST = 1.0
"""Seconds within which messages belong together: a device often says several things at once."""

_MIN_GAPS = 3

_SILENCE_FACTOR = 3.0
"""How many usual gaps may pass: two reports may be lost on the way."""

_LONGEST_OF_FEW = 86_400.0

_LONGEST = 7 * 86_400.0


@final
class ReportInterval:
    """The gaps between the last few times that a device reported: at most eight, so that old habits are forgotten.

    The longest gap does not count once there are three: it may have been a power cut.
    """

    __slots__ = ("_expected_silence", "_gaps", "_last")

    def __init__(self, gaps: Iterable[float] = ()) -> None:
        self._last: float | None = None
        self._gaps: tuple[float, ...] = ()
        self._expected_silence = 0.0
        if gaps:
            self._learn(tuple(gaps)[-_KEPT:])

    @property
    def gaps(self) -> tuple[float, ...]:
        """The gaps in seconds, oldest first."""
        return self._gaps

    def record(self, now: float) -> float:
        """Note a report at *now*, in seconds; return :meth:`expected_silence`."""
        last = self._last
        if last is None:
            self._last = now
        elif (gap := now - last) >= _BURST:
            self._last = now
            self._learn((*self._gaps, gap)[-_KEPT:])
        return self._expected_silence

    def expected_silence(self) -> float:
        """Return for how many seconds after its last report silence is usual; 0 if nothing is known yet."""
        return self._expected_silence

    def join(self, other: ReportInterval) -> None:
        """Take over the interval that *other* learnt of the same device, if it is longer."""
        if len(other._gaps) > len(self._gaps):
            self._learn(other._gaps)
        if other._last is not None:
            self._last = max(other._last, self._last or other._last)

    def _learn(self, gaps: tuple[float, ...]) -> None:
        self._gaps = gaps
        self._expected_silence = _usual_silence(gaps)


def _usual_silence(gaps: tuple[float, ...]) -> float:
    if not gaps:
        return 0.0
    if len(gaps) < _MIN_GAPS:
        return min(_SILENCE_FACTOR * min(gaps), _LONGEST_OF_FEW)
    return min(_SILENCE_FACTOR * sorted(gaps)[-2], _LONGEST)
