"""Turn budget: the share of a server in each turn of the event loop, for all its clients together. Pure.

Work beyond the share waits in a queue and goes on in later turns, first come, first served, a slice at a time. So a
client that floods the server delays itself; it delays other clients by one slice, and everything else in the process by
one share. Time is measured, not estimated, so that the share is as long on a slow computer.
"""

import math
from collections.abc import Callable, Iterator
from typing import Final, TypeAlias, final

SHARE: Final = 0.005
"""Seconds of one turn of the event loop; twice as many in a turn in which an earlier share ends."""

_SLICE: Final = 0.001
"""Seconds of one job in a turn while others wait."""

Job: TypeAlias = Callable[[], object]
"""A piece of work; returns True if a task does it in the next turn, which then has the rest of this one."""


@final
class TurnBudget:
    """The turn budget of one server.

    Args:
        now: The clock that measures the share, in seconds.
    """

    __slots__ = ("_call_soon", "_is_running", "_is_scheduled", "_now", "_queue", "_share_ends", "_slice_ends")

    def __init__(self, now: Callable[[], float], call_soon: Callable[[Callable[[], None]], object]) -> None:
        self._now = now
        self._call_soon = call_soon
        self._queue: dict[Job, None] = {}
        self._share_ends = -math.inf
        self._slice_ends = 0.0
        self._is_running = False
        self._is_scheduled = False

    @property
    def waiting(self) -> int:
        """Number of jobs waiting for a later turn."""
        return len(self._queue)

    def has_time(self) -> bool:
        """Return whether work may start or continue in this turn; otherwise :meth:`defer` it."""
        if self._is_running:
            return self._now() < self._slice_ends
        if self._queue:
            return False
        now = self._now()
        if now < self._share_ends:
            return True
        if self._is_scheduled:  # it is still the turn in which the share began
            return False
        self._share_ends = now + SHARE
        self._schedule()
        return True

    def defer(self, job: Job) -> None:
        """Call *job* once in a later turn, however often it is deferred; it must check :meth:`has_time`."""
        self._queue[job] = None
        self._schedule()

    def run(self, steps: Iterator[object]) -> None:
        """Run as many *steps* as there is time for, and the others in later turns."""

        def go_on() -> None:
            while self.has_time():
                try:
                    next(steps)
                except StopIteration:
                    return
            self.defer(go_on)

        go_on()

    def forget(self, job: Job) -> None:
        """Cancel *job*."""
        self._queue.pop(job, None)

    def _schedule(self) -> None:
        if not self._is_scheduled:
            self._is_scheduled = True
            self._call_soon(self._begin_turn)

    def _begin_turn(self) -> None:
        self._is_scheduled = False
        if not self._queue:
            return
        now = self._now()
        self._share_ends = ends = now + SHARE
        self._schedule()
        self._is_running = True
        try:
            while self._queue and now < ends:
                job = next(iter(self._queue))
                del self._queue[job]
                self._slice_ends = min(now + _SLICE, ends) if self._queue else ends
                if job() is True:
                    break
                now = self._now()
        finally:
            self._is_running = False
