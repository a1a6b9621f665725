"""Pauses between attempts: one policy, with injected randomness."""

import math
from random import Random
from typing import Final, NamedTuple

from homebot.clock import Clock


class Backoff(NamedTuple):
    """Delays that grow up to a cap, with jitter so that clients do not all return at the same moment.

    Attributes:
        first: Longest delay after the first failure, in seconds.
        factor: Growth of that limit from one failure to the next; at least 1.
        cap: Largest limit in seconds,
        late_cap: or this one after failing for longer than `late_after`.
        late_after: Seconds of failures after which a quick return is no longer expected.
        jitter: Random share of the delay, 0 (none) to 1 (full jitter: anything from 0 to the limit).
    """

    first: float
    factor: float
    cap: float
    late_cap: float
    late_after: float
    jitter: float = 1.0

    def delay(self, failures: int, failing_for: float, random: Random) -> float:
        """Return the seconds to wait before the next attempt.

        Args:
            failures: Consecutive failures so far, at least 1.
            failing_for: Seconds since the first of them.
            random: Source of the jitter, seeded for reproducible delays.
        """
        cap = self.cap if failing_for < self.late_after else self.late_cap
        limit = self.first
        for _ in range(failures - 1):
            if limit >= cap:
                break
            limit *= self.factor
        return min(limit, cap) * (1.0 - self.jitter * random.random())


class BackoffCounter:
    """A counter of consecutive failures, and the next delay.

    Failures are counted per policy: one wrong answer after hours of silence is the first one.

    Args:
        steady_after: Seconds that an attempt must last for its failure to count as the first; infinite if only
            :meth:`succeed` resets the count.
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
        """Record the beginning of an attempt."""
        self._began = self._clock.monotonic()

    def succeed(self) -> None:
        """Record that the attempt succeeded, so that a later failure is the first."""
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
"""For a link that is absent or broken."""

# A refused login needs a person. Trying fast fills the broker's log and trips tools that ban by failed logins.
REFUSED_BACKOFF: Final = Backoff(first=15.0, factor=2.0, cap=300.0, late_cap=300.0, late_after=300.0, jitter=0.5)
"""For a broker that refuses."""

# A device that lost power is often back in a minute; more frequent attempts drain batteries.
DEVICE_BACKOFF: Final = Backoff(first=1.0, factor=2.0, cap=60.0, late_cap=300.0, late_after=3600.0, jitter=0.5)
"""For a device or a directory that does not answer."""

DEVICE_REFUSED_BACKOFF: Final = Backoff(first=30.0, factor=2.0, cap=600.0, late_cap=600.0, late_after=600.0, jitter=0.5)
"""For refused logins, which a person has to fix."""

# A device that is starting may give a partial answer, and be right a second later; one of another kind never is.
WRONG_ANSWER_BACKOFF: Final = Backoff(first=2.0, factor=2.0, cap=600.0, late_cap=600.0, late_after=600.0, jitter=0.5)
"""For an answer that breaks the protocol."""
