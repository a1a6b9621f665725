"""A clock of a slow computer."""

from homebot.clock import LoopClock


class BusyClock:
    """A clock by which each look at it takes 2 ms of work."""

    def __init__(self) -> None:
        self._idle = LoopClock(0.0)
        self._worked = 0.0

    def monotonic(self) -> float:
        self._worked += 0.002
        return self._idle.monotonic() + self._worked

    def now(self) -> float:
        return self._idle.now()
