"""Advertisements that were received and wait to be read: few of each device, and not too many in all."""

from __future__ import annotations

from collections import OrderedDict, deque
from dataclasses import dataclass, field

import anyio

from homebot.clock import Clock
from homebot.conventions.bluetooth.advertisement import Advertisement

__all__ = ["Intake", "IntakeCounts"]

EVERY = 1.0
"""Seconds between two advertisements of a device that say the same."""

MAX_WAITING = 1000
MAX_ADDRESSES = 2000


@dataclass(slots=True)
class IntakeCounts:
    """Counts of what became of advertisements.

    Attributes:
        received: All.
        repeated: Those that said nothing new within a second.
        dropped: Those that were too many: the oldest that waited.
    """

    received: int = 0
    repeated: int = 0
    dropped: int = 0


@dataclass(slots=True)
class Intake:
    """A queue of at most 1,000 advertisements; the oldest goes.

    Attributes:
        clock: The clock to live by.
        counts: What became of advertisements.
        heard_at: When one was received last.
    """

    clock: Clock
    counts: IntakeCounts = field(default_factory=IntakeCounts)
    heard_at: float = float("-inf")
    _waiting: deque[Advertisement] = field(default_factory=deque)
    _last: OrderedDict[str, tuple[float, Advertisement]] = field(default_factory=OrderedDict)
    _some_wait: anyio.Event = field(default_factory=anyio.Event)

    def hear(self, advertisement: Advertisement) -> None:
        """Take an advertisement; never waits."""
        now = self.heard_at = self.clock.monotonic()
        self.counts.received += 1
        address = advertisement.address
        last = self._last.pop(address, None)
        if last is not None and now - last[0] < EVERY and last[1].says_the_same(advertisement):
            self._last[address] = last
            self.counts.repeated += 1
            return
        self._last[address] = now, advertisement
        if len(self._last) > MAX_ADDRESSES:
            self._last.popitem(last=False)
        if len(self._waiting) >= MAX_WAITING:
            self._waiting.popleft()
            self.counts.dropped += 1
        self._waiting.append(advertisement)
        self._some_wait.set()

    async def next(self) -> Advertisement:
        """Return the advertisement that has waited longest; wait for one."""
        while not self._waiting:
            self._some_wait = anyio.Event()
            await self._some_wait.wait()
        return self._waiting.popleft()
