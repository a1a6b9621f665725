"""Things to do at a later time or in slices: whoever owns the clock asks what is due. No I/O."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Final, final

from homebot.clock import Clock
from homebot.timer_queue import TimerQueue

__all__ = ["BrokerTimers", "Deadline", "SliceBudget"]


@final
class Deadline:
    """One thing to do at one time."""

    __slots__ = ("_queue", "action", "when")

    def __init__(self, when: float, action: Callable[[], None], queue: TimerQueue[Deadline, None]) -> None:
        self.when = when
        self.action: Callable[[], None] | None = action
        self._queue = queue

    def cancel(self) -> None:
        """Do not do it; harmless afterwards."""
        self.action = None
        self._queue.discard(self)


@final
class BrokerTimers:
    """A timer queue of deadlines.

    Args:
        wake: Called with the time of the earliest deadline whenever it moves forward.
    """

    def __init__(self, wake: Callable[[float], None] | None = None) -> None:
        self.wake = wake
        self._queue: TimerQueue[Deadline, None] = TimerQueue()

    @property
    def earliest(self) -> float | None:
        """Time of the next deadline, on the clock's monotonic scale, or None."""
        return self._queue.next()

    def at(self, when: float, action: Callable[[], None]) -> Deadline:
        """Have *action* called once *when* has come."""
        earliest = self._queue.next()
        deadline = Deadline(when, action, self._queue)
        self._queue.set(deadline, when, None)
        if self.wake is not None and (earliest is None or when < earliest):
            self.wake(when)
        return deadline

    def run(self, now: float) -> None:
        """Do everything due at *now*, in order of time; what is noted meanwhile has to wait for the next run."""
        due: deque[Deadline] = deque()
        while (found := self._queue.pop(now)) is not None:
            due.append(found[0])
        try:
            while due:
                action = due.popleft().action
                if action is not None:
                    action()
        finally:
            for left in due:
                self._queue.set(left, left.when, None)


SLICE: Final = 5_000
PERIOD: Final = 0.01  # half of the time is for the others


@final
class SliceBudget:
    """The budget of work that can take long, for all clients of a broker together.

    Who finds nothing left asks for a later call; those who wait get their slices in turn.

    Args:
        clock: The time to go by.
        deadlines: Where the next slice is noted.
        slice: How much may be done at once, in units of about a microsecond.
        period: Seconds from the beginning of a slice to that of the next; 0 is a turn of the event loop.

    Attributes:
        units: What is left of this slice, however long ago it began; not above 0 where it is used up.
    """

    def __init__(self, clock: Clock, deadlines: BrokerTimers, slice: int = SLICE, period: float = PERIOD) -> None:  # noqa: A002 - the word for it
        self._clock = clock
        self._deadlines = deadlines
        self._slice = slice
        self._period = period
        self.units = slice
        self._began = clock.monotonic()
        self._waiting: dict[Callable[[], None], None] = {}
        self._is_due = False

    @property
    def left(self) -> bool:
        """True if anything may be done now."""
        if self.units > 0:
            return True
        now = self._clock.monotonic()
        if self._waiting or now < self._began + self._period:
            return False
        self._refill(now)
        return True

    @property
    def waiting(self) -> int:
        """Number of those that wait for a later slice."""
        return len(self._waiting)

    def spend(self, units: int) -> None:
        """Count work that was done."""
        if self.units == self._slice:
            self._began = self._clock.monotonic()
        self.units -= units

    def later(self, job: Callable[[], None]) -> None:
        """Call *job* in a later slice, once, however often it is asked for; it looks at :attr:`left` itself."""
        self._waiting[job] = None
        if not self._is_due:
            self._is_due = True
            self._deadlines.at(self._clock.monotonic() + self._period, self._run)

    def forget(self, job: Callable[[], None]) -> None:
        """Do not call *job* any more."""
        self._waiting.pop(job, None)

    def _run(self) -> None:
        self._is_due = False
        self._refill(self._clock.monotonic())
        for job in list(self._waiting):
            if self.units <= 0:
                break
            if job in self._waiting:
                del self._waiting[job]
                job()
        if self._waiting and not self._is_due:
            self._is_due = True
            self._deadlines.at(self._clock.monotonic() + self._period, self._run)

    def _refill(self, now: float) -> None:
        self.units = self._slice
        self._began = now
