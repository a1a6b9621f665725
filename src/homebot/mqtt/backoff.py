"""Delay before trying again: one policy, pure, the randomness handed in."""

from __future__ import annotations

from dataclasses import dataclass
from random import Random
from typing import Final

__all__ = ["LINK_BACKOFF", "REFUSED_BACKOFF", "Backoff"]


@dataclass(frozen=True, slots=True)
class Backoff:
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


# A broker in the house is back a second after its restart, and a try costs one refused TCP connect: with
# 1.5 s plus the handshake a client is back within 2 s. A hub or router that reboots takes a few minutes;
# who is away for longer is switched off, and 30 s spare its log.
LINK_BACKOFF: Final = Backoff(first=0.1, factor=2.0, cap=1.5, late_cap=30.0, late_after=300.0)
"""For a link that is absent or broke."""

# A refused login needs a person. Trying fast fills the broker's log and trips tools that ban by failed logins.
REFUSED_BACKOFF: Final = Backoff(first=15.0, factor=2.0, cap=300.0, late_cap=300.0, late_after=300.0, jitter=0.5)
"""For a broker that answered with no."""
