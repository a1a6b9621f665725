"""The scheduler: makes each planned call when its time has come."""

import math
from collections.abc import Callable, Hashable

import anyio

from homebot.clock import Clock, TimeSlice
from homebot.support.timer_queue import TimerQueue

__all__ = ["Scheduler"]


class Scheduler:
    """A timer queue of callbacks that is kept by one task, in the clock's own time."""

    def __init__(self, clock: Clock, most: int = 100_000) -> None:
        self._clock = clock
        self._most = most
        self._queue: TimerQueue[Hashable, Callable[[], None]] = TimerQueue()
        self._wakes_at = math.inf
        self._earlier = anyio.Event()

    def plan(self, name: Hashable, after: float, callback: Callable[[], None]) -> bool:
        """Plan *callback* in *after* seconds, replacing the plan of *name*; return False if there is no room."""
        if name not in self._queue and len(self._queue) >= self._most:
            return False
        at = self._clock.monotonic() + after
        self._queue.set(name, at, callback)
        if at < self._wakes_at:
            self._earlier.set()
        return True

    def drop(self, name: Hashable) -> None:
        """Plan nothing under *name* any more."""
        self._queue.discard(name)

    async def run(self) -> None:
        """Run the callbacks that are due, until cancelled."""
        while True:
            self._earlier = anyio.Event()
            next_at = self._queue.next()
            self._wakes_at = math.inf if next_at is None else next_at
            with anyio.move_on_after(max(0.0, self._wakes_at - self._clock.monotonic())):
                await self._earlier.wait()
            work = TimeSlice(self._clock)
            while (due := self._queue.pop(self._clock.monotonic())) is not None:
                _, callback = due
                callback()
                if work.is_over:
                    await work.pause()
