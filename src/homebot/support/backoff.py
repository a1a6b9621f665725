"""Pauses between attempts: one policy, with the randomness handed in."""

import math
from random import Random
from typing import Final, NamedTuple

from homebot.clock import Clock

__all__ = [
    "DEVICE_BACKOFF",
    "DEVICE_REFUSED_BACKOFF",
    "LINK_BACKOFF",
    "REFUSED_BACKOFF",
    "WRONG_ANSWER_BACKOFF",
    "Backoff",
    "BackoffCounter",
]


class Backoff(NamedTuple):
    """Delays that double up to a cap, with jitter so that many clients do not come back in one moment.

    Attributes:
        first: Longest delay after the first failure, in seconds.
        factor: Growth of that limit from one failure to the next; at least 1.
        cap: The limit grows to this many seconds and no further, ...
        late_cap: ... unless it has failed for longer than `late_after`; then to this many.
        late_after: Seconds of failing after which a quick return is no longer expected.
        jitter: Random share of the delay, 0 (none) to 1 (full jitter: anything from 0 to the limit).
    """

    first: float
    factor: float
    cap: float
    late_cap: float
    late_after: float
    jitter: float = 1.0

    def delay(self, failures: int, failing_for: float, random: Random) -> float:
        """Return seconds to wait before the next try.

        Args:
            failures: Failures in a row up to now, at least 1.
            failing_for: Seconds since the first of them.
            random: Source of the jitter; a seeded one gives the same delays again.
        """
        cap = self.cap if failing_for < self.late_after else self.late_cap
        limit = self.first
        for _ in range(failures - 1):
            if limit >= cap:
                break
            limit *= self.factor
        return min(limit, cap) * (1.0 - self.jitter * random.random())


class BackoffCounter:
    """Counter of consecutive failures, with the next delay.

    The failures of each policy count by themselves: one wrong answer after hours of silence is the first one.

    Args:
        steady_after: Seconds that an attempt has to last for its failure to count as the first; infinite where only
            :meth:`succeed` says so.
    """

    def __init__(self, clock: Clock, random: Random, steady_after: float = math.inf) -> None:
        self._clock = clock
        self._random = random
        self._steady_after = steady_after
        self._began = clock.monotonic()
        self._failures: dict[Backoff, tuple[int, float]] = {}

    @property
    def has_failed(self) -> bool:
        """True after a failure, until an attempt succeeds."""
        return bool(self._failures)

    def begin(self) -> None:
        """Note that an attempt begins."""
        self._began = self._clock.monotonic()

    def succeed(self) -> None:
        """Note that the attempt succeeded: its failure, if it fails later, is the first."""
        self._failures.clear()

    def fail(self, backoff: Backoff) -> float:
        """Count a failure; return the seconds to wait before the next attempt."""
        now = self._clock.monotonic()
        if now - self._began > self._steady_after:
            self._failures.clear()
        failures, since = self._failures.get(backoff, (0, now))
        self._failures[backoff] = failures + 1, since
        return backoff.delay(failures + 1, now - since, self._random)


# A broker in the house is back a second after its restart, and a try costs one refused TCP connect: with
# 1.5 s plus the handshake a client is back within 2 s. A hub or router that reboots takes a few minutes;
# a longer absence means switched off, and 30 s keep the log short.
LINK_BACKOFF: Final = Backoff(first=0.1, factor=2.0, cap=1.5, late_cap=30.0, late_after=300.0)
"""For a link that is absent or broke."""

# A refused login needs a person. Trying fast fills the broker's log and trips tools that ban by failed logins.
REFUSED_BACKOFF: Final = Backoff(first=15.0, factor=2.0, cap=300.0, late_cap=300.0, late_after=300.0, jitter=0.5)
"""For a broker that answered with no."""

# A device that lost its power is often back in a minute; one that is asked more often than that pays with its battery.
DEVICE_BACKOFF: Final = Backoff(first=1.0, factor=2.0, cap=60.0, late_cap=300.0, late_after=3600.0, jitter=0.5)
"""For a device, or a directory of devices, that does not answer."""

DEVICE_REFUSED_BACKOFF: Final = Backoff(first=30.0, factor=2.0, cap=600.0, late_cap=600.0, late_after=600.0, jitter=0.5)
"""For refused logins: a person has to change something."""

# One that is starting may answer half of what it should, and be right a second later; one of another kind never is.
WRONG_ANSWER_BACKOFF: Final = Backoff(first=2.0, factor=2.0, cap=600.0, late_cap=600.0, late_after=600.0, jitter=0.5)
"""For an answer that breaks the rules of the protocol."""
