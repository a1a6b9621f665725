"""A server's share of the event loop: a few milliseconds each time the loop goes round, for all its clients together.

Whoever wants more waits in line, one piece of work each time round, first come, first served. So a client that floods
the server delays other clients, and everything else in the process by that share at most.
"""

from __future__ import annotations

import asyncio
import time
from collections import deque
from collections.abc import Callable
from typing import final

__all__ = ["Turns"]

_SHARE = 0.005
"""Seconds after which no further piece of work is begun in this round of the loop."""


@final
class Turns:
    """Hands out turns; a piece of work is what is done between two of them.

    Args:
        now: Reads the clock that the share is measured with, in seconds.
    """

    def __init__(self, now: Callable[[], float] = time.perf_counter) -> None:
        self._now = now
        self._began: float | None = None
        self._queue: deque[Callable[[], bool]] = deque()
        self._is_scheduled = False

    def has_time(self) -> bool:
        """Return whether work may begin now; where not, :meth:`turn` or :meth:`defer` waits for it."""
        if self._queue:
            return False
        if self._began is None:
            self._began = self._now()
            self._schedule()
            return True
        return self._now() - self._began < _SHARE

    async def turn(self) -> None:
        """Wait until work may begin."""
        if self.has_time():
            return
        waiter: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        self._queue.append(lambda: _wake(waiter))
        self._schedule()
        await waiter

    def defer(self, work: Callable[[], None]) -> None:
        """Call *work* once it may begin."""

        def begin() -> bool:
            work()
            return True

        self._queue.append(begin)
        self._schedule()

    def _schedule(self) -> None:
        if not self._is_scheduled:
            self._is_scheduled = True
            asyncio.get_running_loop().call_soon(self._begin_round)

    def _begin_round(self) -> None:
        """Let the first in line begin who still waits; where nobody does, time is there for whoever asks first."""
        self._is_scheduled = False
        self._began = None
        while self._queue:
            self._began = self._now()
            self._schedule()
            if self._queue.popleft()():
                return


def _wake(waiter: asyncio.Future[None]) -> bool:
    if waiter.done():  # cancelled meanwhile
        return False
    waiter.set_result(None)
    return True
