"""End of a burst of announcements: a house that comes at once is described once, and not anew for each message."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Final, final

from homebot.clock import Clock

__all__ = ["Burst"]

_LONGEST: Final = 10.0
"""Seconds for which the end is waited for at first: a house of 4,000 devices announces itself in about as many."""

_LONGEST_AGAIN: Final = 60.0
"""The same in a burst that goes on: the wait doubles up to this, as on a slow computer each description is dear."""


@final
class Burst:
    """Wait for the end of a burst.

    Args:
        clock: The clock.
        announced: Returns the number of announcements so far.
        pause: Waits for the time without an announcement after which a burst is over.
    """

    def __init__(self, clock: Clock, announced: Callable[[], int], pause: Callable[[], Awaitable[None]]) -> None:
        self._clock = clock
        self._announced = announced
        self._pause = pause
        self._seen = 0
        self._longest = _LONGEST

    async def wait(self, is_urgent: Callable[[], bool] = lambda: False) -> None:
        """Wait while announcements keep coming, unless that *is_urgent*; return at once if none came since."""
        until = self._clock.monotonic() + self._longest
        while (announced := self._announced()) != self._seen:
            if is_urgent():
                return
            if self._clock.monotonic() >= until:
                self._longest = min(2 * self._longest, _LONGEST_AGAIN)
                return
            self._seen = announced
            await self._pause()
        self._longest = _LONGEST
