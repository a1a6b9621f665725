"""Window of own publishes that may be open on one link at once; the others wait in their order."""

from __future__ import annotations

import asyncio
from collections import deque
from typing import final

from homebot.errors import LinkError

__all__ = ["SendWindow"]


@final
class SendWindow:
    """A bound whose waiters are set free when the link is lost.

    Args:
        size: Places at the start; below 1 others have to end first.
    """

    def __init__(self, size: int) -> None:
        self._free = size
        self._waiters: deque[asyncio.Future[None]] = deque()

    async def acquire(self) -> None:
        """Wait for a place, behind those who waited before.

        Raises:
            LinkError: The link was lost meanwhile.
        """
        if self._free > 0:
            self._free -= 1
            return
        waiter = asyncio.get_running_loop().create_future()
        self._waiters.append(waiter)
        try:
            await waiter
        except asyncio.CancelledError:
            if waiter.done() and not waiter.cancelled() and waiter.exception() is None:
                self.release()  # the place came in the same moment
            raise

    def release(self) -> None:
        """A publish has ended: its place is for the next."""
        self._free += 1
        while self._free > 0 and self._waiters:
            waiter = self._waiters.popleft()
            if not waiter.done():
                self._free -= 1
                waiter.set_result(None)

    def close(self, words: str) -> None:
        """Tell all who wait that they wait in vain, because of *words*."""
        while self._waiters:
            waiter = self._waiters.popleft()
            if not waiter.done():
                waiter.set_exception(LinkError(words))
