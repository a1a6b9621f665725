"""A limit on the rate of events or amounts. Pure: callers pass the time."""

import math
from typing import final


@final
class RateLimit:
    """A limit on the average amount per second, and on the burst after a quiet time.

    Args:
        per_second: The average amount per second; more than 0.
        most_ahead: Largest excess that counts; more does not prolong the wait.
    """

    def __init__(self, per_second: float, at_once: float, most_ahead: float = math.inf) -> None:
        self._per_second = per_second
        self._at_once = at_once
        self._most_ahead = most_ahead
        self._left = at_once
        self._at = 0.0

    def charge(self, now: float, amount: float = 1.0) -> float:
        """Count *amount*; return the seconds until it is within the limit, usually 0."""
        self._left = max(self.room(now) - amount, -self._most_ahead)
        return max(0.0, -self._left / self._per_second)

    def admits(self, now: float) -> bool:
        """Return whether one more is within the limit now; count it if it is."""
        has_room = self.room(now) >= 1
        if has_room:
            self._left -= 1
        return has_room

    def room(self, now: float) -> float:
        """Return the amount that is allowed now; below 0 after an excess."""
        self._left = min(self._at_once, self._left + (now - self._at) * self._per_second)
        self._at = now
        return self._left
