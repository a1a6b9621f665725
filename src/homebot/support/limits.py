"""Limits on how often something happens: on an amount, and on each kind of an event. Pure: callers pass the time."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar, final

from homebot.support.bounded_map import BoundedMap

Kind = TypeVar("Kind")
Item = TypeVar("Item")


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


@final
@dataclass(slots=True, eq=False)
class LimitInterval(Generic[Item]):
    """The current interval of one kind: how many passed, how many were held back, and the newest of these."""

    began: float
    passed: int = 0
    held_back: int = 0
    newest: Item | None = None

    def admit(self, most: int, item: Item | None = None, count: int = 1) -> bool:
        """Return whether one more passes, of at most *most*; if not, *item* is held back in place of the one before."""
        if self.passed < most:
            self.passed += 1
            return True
        self.held_back, self.newest = self.held_back + count, item
        return False

    def release(self) -> tuple[Item | None, int]:
        """Return the newest that was held back, and the number of all, and forget both."""
        held = self.newest, self.held_back
        self.newest, self.held_back = None, 0
        return held


@final
class Limiter(BoundedMap[Kind, LimitInterval[Item]]):
    """The intervals of the *most* recently used kinds; each begins with the first of its kind.

    Args:
        seconds: The length of an interval.
        on_over: Called with a kind and its interval when it is over and the next of its kind comes, or it is dropped.
            By default its count goes on until it is released.
    """

    def __init__(
        self, seconds: float, most: int, on_over: Callable[[Kind, LimitInterval[Item]], object] = lambda *_: None
    ) -> None:
        super().__init__(most, on_over)
        self._seconds = seconds

    def of(self, kind: Kind, now: float) -> LimitInterval[Item]:
        """Return the interval of *kind* at *now*."""
        interval = self.get(kind)
        if interval is None:
            interval = self[kind] = LimitInterval(now)
            return interval
        self.move_to_end(kind)
        if not 0 <= now - interval.began < self._seconds:
            self._on_drop(kind, interval)
            interval.began, interval.passed = now, 0
        return interval

    def drop(self, now: float = math.inf) -> None:
        """Drop the intervals that are over, from the least recently used on up to the first that is not."""
        while self and not 0 <= now - next(iter(self.values())).began < self._seconds:
            self._on_drop(*self.popitem(last=False))
