"""The one clock that everything with a sense of time is given.

Two readings: :meth:`Clock.monotonic` for durations, which never goes back, and :meth:`Clock.now` for stamps
that leave the process. Both advance together, so a test that moves one moves both.
"""

from __future__ import annotations

import asyncio
import time
from typing import Protocol, final

__all__ = ["Clock", "LoopClock", "ManualClock"]


class Clock(Protocol):
    """A source of time."""

    def monotonic(self) -> float:
        """Seconds since an arbitrary start; never goes back."""
        ...

    def now(self) -> float:
        """Seconds since the Unix epoch, UTC."""
        ...


@final
class LoopClock:
    """The clock of the running event loop; under a virtual-time loop this is virtual time.

    Args:
        epoch: What :meth:`now` says at the moment of making the clock, in seconds since the Unix epoch;
            by default the computer's own time.
    """

    def __init__(self, epoch: float | None = None) -> None:
        self._loop_time = asyncio.get_running_loop().time
        self._offset = (time.time() if epoch is None else epoch) - self._loop_time()

    def monotonic(self) -> float:
        """Seconds of the event loop's time."""
        return self._loop_time()

    def now(self) -> float:
        """Seconds since the Unix epoch: the start plus what the loop's clock has run since."""
        return self._offset + self._loop_time()


@final
class ManualClock:
    """A clock that stands still until it is moved; for tests of code without an event loop."""

    def __init__(self, start: float = 0.0) -> None:
        self._now = start

    def monotonic(self) -> float:
        """Seconds; equal to :meth:`now`."""
        return self._now

    def now(self) -> float:
        """Seconds since the Unix epoch."""
        return self._now

    def advance(self, seconds: float) -> None:
        """Move the clock forward by *seconds* (at least 0)."""
        if seconds < 0:
            raise ValueError(f"a clock does not go back: {seconds}")
        self._now += seconds
