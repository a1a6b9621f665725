"""Long work in slices of a few milliseconds, between which every other task gets its turn."""

from __future__ import annotations

from typing import final

import anyio.lowlevel

from homebot.clock import Clock

__all__ = ["SLICE", "TimeSlice"]

SLICE = 0.005
"""Seconds of one slice: how much work a piece is nobody knows beforehand, for one device may have hundreds of parts."""


@final
class TimeSlice:
    """The slice that one task works in now; it begins when this is made.

    ``if slice.is_over: await slice.pause()`` after each piece of work.

    Args:
        clock: Measures it.
    """

    def __init__(self, clock: Clock) -> None:
        self._monotonic = clock.monotonic
        self._ends = clock.monotonic() + SLICE

    @property
    def is_over(self) -> bool:
        """True if it is somebody else's turn."""
        return self._monotonic() >= self._ends

    async def pause(self) -> None:
        """Let all others have their turn, and begin the next slice."""
        await anyio.lowlevel.checkpoint()
        self._ends = self._monotonic() + SLICE
