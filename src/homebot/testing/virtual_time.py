"""An event loop whose time jumps: whenever nothing is ready, the next timer is due at once.

An hour of timers passes in milliseconds, every timer fires at exactly its own time, and nothing depends on the speed of
the computer. Keep real sockets and worker threads off this loop: it does not wait for them while a timer is set.
"""

from __future__ import annotations

import asyncio
import math
import selectors
from collections import deque
from collections.abc import Callable
from contextvars import Context
from typing import TypeVarTuple

from homebot.errors import UsageError

__all__ = ["VirtualTimeLoop"]

Ts = TypeVarTuple("Ts")

RESOLUTION = 1e-6  # seconds; timers closer than this fire together. Far above the steps of a float at 30 years
SELDOM = 50  # turns of a busy loop after which files are looked at all the same
STUCK_AFTER = 5.0  # real seconds in which a thread or a signal may still wake a loop that has no timer


class VirtualTimeLoop(asyncio.SelectorEventLoop):
    """An event loop in virtual time, which starts at 0.

    Made for ``asyncio.Runner(loop_factory=VirtualTimeLoop)`` and its likes. A program that waits for what cannot come,
    with nothing ready and no timer set, ends with :class:`homebot.errors.UsageError` after 5 real seconds.
    """

    def __init__(self) -> None:
        self._jumping = _JumpingSelector()
        super().__init__(self._jumping)
        self._clock_resolution = RESOLUTION  # asyncio's own is lost in the float after 97 days: no timer would be due

    def time(self) -> float:
        """Seconds of virtual time since the loop was made."""
        return self._jumping.now

    async def settled(self) -> None:
        """Wait until all that can happen at this moment has happened; no time passes."""
        waiter: asyncio.Future[None] = self.create_future()
        self._jumping.waiters.append(waiter)
        await waiter

    def call_at(
        self,
        when: float,
        callback: Callable[[*Ts], object],
        *args: *Ts,
        context: Context | None = None,
    ) -> asyncio.TimerHandle:
        """Call *callback* at *when*; a timer at infinity, as of ``anyio.sleep_forever``, does not count as one."""
        if when == math.inf:
            return asyncio.TimerHandle(when, callback, args, self, context)
        return super().call_at(when, callback, *args, context=context)


class _JumpingSelector(selectors.DefaultSelector):
    """Passes time instead of waiting."""

    now = 0.0

    def __init__(self) -> None:
        super().__init__()
        self.waiters: deque[asyncio.Future[None]] = deque()
        self._unasked = 0

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        if timeout is None and not self.waiters:
            return self._select_or_give_up()
        if timeout == 0 and self._unasked < SELDOM:  # there is something to do: the system call would double its cost
            self._unasked += 1
            return []
        self._unasked = 0
        ready = super().select(0)
        if timeout == 0 or ready:
            return ready
        if self.waiters:
            self._wake_waiters()
        elif timeout is not None:
            self.now += timeout
        return ready

    def _wake_waiters(self) -> None:
        while self.waiters:
            waiter = self.waiters.popleft()
            if not waiter.done():
                waiter.set_result(None)

    def _select_or_give_up(self) -> list[tuple[selectors.SelectorKey, int]]:
        ready = super().select(STUCK_AFTER)
        if not ready:
            raise UsageError("nothing is ready and no timer is set: what the program waits for cannot come")
        return ready
