"""A scheduler of callbacks."""

import math
from collections.abc import Callable, Hashable

import anyio

from homebot.clock import Clock, TimeSlice
from homebot.support.timer_queue import TimerQueue


class Scheduler:
    """A timer queue of callbacks, served by one task on the injected clock."""

    def __init__(self, clock: Clock, most: int = 100_000) -> None:
        self._clock = clock
        self._most = most
        self._queue: TimerQueue[Hashable, Callable[[], None]] = TimerQueue()
        self._wakes_at = math.inf
        self._earlier = anyio.Event()

    def plan(self, name: Hashable, after: float, callback: Callable[[], None]) -> bool:
        """Schedule *callback* in *after* seconds, replacing the one of *name*; return False if the queue is full."""
        if name not in self._queue and len(self._queue) >= self._most:
            return False
        at = self._clock.monotonic() + after
        self._queue.set(name, at, callback)
        if at < self._wakes_at:
            self._earlier.set()
        return True

    def drop(self, name: Hashable) -> None:
        """Cancel the callback of *name*."""
        self._queue.discard(name)

    async def run(self) -> None:
        """Run due callbacks until cancelled."""
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
