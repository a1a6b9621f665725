"""How often a device speaks by itself, and how long its silence is therefore no bad sign. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

__all__ = ["Rhythm"]

_KEPT = 8
_BURST = 1.0
"""Seconds within which messages belong together: a device often says several things at once."""

_FEW = 3
_TIMES = 3.0
"""How many usual gaps may pass: two reports may be lost on the way."""

_LONGEST_OF_FEW = 86_400.0
_LONGEST = 7 * 86_400.0


@final
class Rhythm:
    """The gaps between the last few times that a device spoke: at most eight, so that old habits are forgotten.

    The longest gap does not count once there are three: it may have been a power cut.
    """

    __slots__ = ("_gaps", "_last")

    def __init__(self, gaps: Iterable[float] = ()) -> None:
        self._gaps = list(gaps)[-_KEPT:]
        self._last: float | None = None

    @property
    def gaps(self) -> tuple[float, ...]:
        """The gaps in seconds, oldest first."""
        return tuple(self._gaps)

    def heard(self, now: float) -> None:
        """Note that it spoke at *now*, in seconds."""
        if self._last is None:
            self._last = now
            return
        gap = now - self._last
        if gap < _BURST:
            return
        self._last = now
        self._gaps.append(gap)
        if len(self._gaps) > _KEPT:
            del self._gaps[0]

    def patience(self) -> float:
        """Return for how many seconds after its last word its silence is usual; 0 where nothing is known yet."""
        if not self._gaps:
            return 0.0
        if len(self._gaps) < _FEW:
            return min(_TIMES * min(self._gaps), _LONGEST_OF_FEW)
        return min(_TIMES * sorted(self._gaps)[-2], _LONGEST)

    def join(self, other: Rhythm) -> None:
        """Take over what *other* learnt of the same device, where that is more."""
        if len(other._gaps) > len(self._gaps):
            self._gaps = other._gaps
        if other._last is not None:
            self._last = max(other._last, self._last or other._last)
