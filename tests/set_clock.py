"""A wall clock that somebody sets, of a computer that sleeps."""

import asyncio


class SetClock:
    """The loop's time, and a wall clock that somebody sets.

    Attributes:
        wall: The reading of the wall clock at the loop's time 0, in seconds since the Unix epoch.
        slept: Seconds for which the computer slept.
    """

    def __init__(self, wall: float) -> None:
        self._time = asyncio.get_running_loop().time
        self.wall = wall
        self.slept = 0.0

    def monotonic(self) -> float:
        """Return seconds since an arbitrary start."""
        return 1000.0 + self._time()

    def now(self) -> float:
        """Return seconds since the Unix epoch."""
        return self.wall + self._time()
