"""Numbers in a device's own steps, and percent. Pure; rounds as Home Assistant does.

Source: Home Assistant core 2025.4, ``util/scaling.py`` and ``util/percentage.py``.
"""

from __future__ import annotations

from dataclasses import dataclass

from homebot.errors import WireError

__all__ = ["Scale"]


@dataclass(frozen=True, slots=True)
class Scale:
    """Two values of a device that stand for 0 % and 100 %; the first may be the larger one.

    Raises:
        WireError: Both are the same.
    """

    zero: int
    full: int

    def __post_init__(self) -> None:
        if self.zero == self.full:
            raise WireError(f"0 % and 100 % are the same value, {self.zero}")

    def percent(self, value: float) -> float:
        """Return *value* in whole percent, rounded towards the zero; outside of 0 to 100 where the value is outside."""
        value = min(max(value, -_FAR), _FAR)
        return float((value - self.zero) * 100 // (self.full - self.zero))

    def value(self, percent: float) -> float:
        """Return the exact value that stands for *percent*."""
        return percent * (self.full - self.zero) / 100 + self.zero


_FAR = 1e100
"""Beyond any device's values, and still a number after multiplication."""
