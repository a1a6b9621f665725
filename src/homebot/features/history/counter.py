"""The total of one counter without its glitches and its jitter. Pure."""

import math
from typing import Final, final

_NEAR: Final = 0.9
"""The share of a total above which a lower one is jitter, or back from a glitch: Home Assistant's limit of a reset."""

_JUMP: Final = 0.25
_HOUR: Final = 3_600_000
_ONE: Final = 1.0


@final
class CounterTotal:
    """Decides which totals of a counter are recorded; the sum of the rises between these is what it counted.

    A fall by less than a tenth is jitter: nothing counts until the total exceeds the old one. A deeper one waits: what
    returns near the old total was a glitch, as the 0 of a starting inverter. If it grows instead, it is recorded:
    from near zero as a reset, after a 0, as its first value counts; from elsewhere as another meter, whose first value
    does not. A jump back near the old total within an hour is no rise.

    Args:
        last: The last recorded total; None if there is none.
    """

    __slots__ = ("_before", "_fell_at", "_low", "last")

    def __init__(self, last: float | None) -> None:
        self.last = last
        self._low: float | None = None  # after a fall that may be a glitch
        self._before, self._fell_at = math.inf, 0

    def record(self, value: float, at: int) -> tuple[float, ...]:
        """Return the totals to record for *value* at *at* milliseconds; NaN is before one that is no rise."""
        last, low, before = self.last, self._low, self._before
        if last is None:
            recorded: tuple[float, ...] = (value,)
        elif value >= _NEAR * before and value - last >= _JUMP * before and at - self._fell_at <= _HOUR:
            recorded, self._before = (math.nan, before, max(value, before)), math.inf
        elif value >= last:
            recorded = (value,)
        elif value >= _NEAR * last:
            recorded = ()
        elif low is None or value <= low:
            self._low = value
            return ()
        else:
            is_reset = low < max(last * (1 - _NEAR), min(last / 2, _ONE))
            recorded, self._before, self._fell_at = (0.0 if is_reset else low, value), last, at
        self._low = None
        self.last = recorded[-1] if recorded else last
        return recorded
