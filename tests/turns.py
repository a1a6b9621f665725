"""How long others wait for their turns of the event loop, whatever machine it is and whatever else runs there.

Three things make a turn long that the code did not: the machine is slower than another, so limits are for a reference
machine, and what this one takes for the same work is measured; it was taken away for a moment, so of some runs the
best counts, as work that takes long does so in each; and the garbage collector looks through all that the tests of this
process hold, so it rests meanwhile. Mark such a test ``no_cover`` too: to measure coverage takes several times as long.
"""

import gc
import math
import time
from collections.abc import Awaitable, Callable

import anyio
import anyio.lowlevel

REFERENCE = 0.005
"""Seconds of the processor for :func:`_work` on the reference machine; a virtual one with two cores."""

_PULSE = 0.05
_SOME = 0.005


class Turns:
    """Watches how long the processor was busy with others between two turns.

    Attributes:
        longest: Seconds of the processor; no other program counts.
    """

    def __init__(self) -> None:
        self.longest = 0.0
        self._last: float | None = None

    def take(self) -> None:
        """Note that it is our turn."""
        now = time.thread_time()
        if self._last is not None:
            self.longest = max(self.longest, now - self._last)
        self._last = now

    async def take_all(self) -> None:
        """Take every turn of the loop, until it is cancelled."""
        while True:
            self.take()
            await anyio.lowlevel.checkpoint()

    async def take_some(self) -> None:
        """Take a turn each few milliseconds, until it is cancelled: the longest is then of all turns between two."""
        while True:
            self.take()
            await anyio.sleep(_SOME)


async def longest_turn(measure: Callable[[Turns], Awaitable[None]], *, limit: float) -> float:
    """Run *measure*, up to three times where it took *limit* or longer, and return the longest turn of the best run.

    In seconds of the processor of the reference machine.
    """
    best = math.inf
    was_enabled = gc.isenabled()
    gc.disable()
    try:
        for _ in range(3):
            turns, before = Turns(), slowness()
            await measure(turns)
            best = min(best, turns.longest / max(before, slowness()))
            if best < limit:
                break
    finally:
        if was_enabled:
            gc.enable()
    return best


class Lateness:
    """Counts by how much the event loop was late, because the machine was busy with others.

    Attributes:
        seconds: The sum since it began to watch.
    """

    def __init__(self) -> None:
        self.seconds = 0.0

    async def watch(self) -> None:
        """Watch until it is cancelled."""
        while True:
            began = anyio.current_time()
            await anyio.sleep(_PULSE)
            self.seconds += max(0.0, anyio.current_time() - began - _PULSE)


def slowness() -> float:
    """Return how many times longer this thread takes now for the same work than the reference machine; at least 1."""
    began = time.thread_time()
    for _ in range(5):
        _work()
    return max(1.0, (time.thread_time() - began) / 5 / REFERENCE)


def _work() -> None:
    """Do a bit of what Python code mostly does: calls, attributes, dictionaries, texts."""
    found: dict[str, int] = {}
    for number in range(40_000):
        key = f"{number % 100}"
        found[key] = found.get(key, 0) + len(key)
