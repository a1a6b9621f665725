"""Work for later, run by the owner of the clock. No I/O."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import final

from homebot.support.timer_queue import TimerQueue


@final
class Deadline:
    """A callback and its time."""

    __slots__ = ("_queue", "action", "when")

    def __init__(self, when: float, action: Callable[[], None], queue: TimerQueue[Deadline, None]) -> None:
        self.when = when
        self.action: Callable[[], None] | None = action
        self._queue = queue

    def cancel(self) -> None:
        """Cancel the callback; does nothing after the call."""
        self.action = None
        self._queue.discard(self)


@final
class BrokerTimers:
    """A timer queue of deadlines.

    Args:
        wake: Called with the time of the earliest deadline whenever that becomes earlier.
    """

    def __init__(self, wake: Callable[[float], None] | None = None) -> None:
        self.wake = wake
        self._queue: TimerQueue[Deadline, None] = TimerQueue()

    @property
    def earliest(self) -> float | None:
        """The time of the next deadline, on the monotonic clock, or None."""
        return self._queue.next()

    def at(self, when: float, action: Callable[[], None]) -> Deadline:
        """Schedule *action* for the time *when*."""
        earliest = self._queue.next()
        deadline = Deadline(when, action, self._queue)
        self._queue.set(deadline, when, None)
        if self.wake is not None and (earliest is None or when < earliest):
            self.wake(when)
        return deadline

    def run(self, now: float) -> None:
        """Run the callbacks due at *now*, in order; those added meanwhile wait for the next run."""
        due: deque[Deadline] = deque()
        while (entry := self._queue.pop(now)) is not None:
            due.append(entry[0])
        try:
            while due:
                action = due.popleft().action
                if action is not None:
                    action()
        finally:
            for left in due:
                self._queue.set(left, left.when, None)
