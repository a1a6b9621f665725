"""rclpy's times, durations, clocks and rates."""

from __future__ import annotations

import time
from typing import Any, ClassVar, Self

from homebot.compat.messages import to_program
from homebot.compat.remote import CONTEXT
from homebot.messages import Duration, Time

_SECOND = 10**9


class RclpyDuration(int):
    """A duration in nanoseconds; the clock type is ignored."""

    message: ClassVar[type[Duration | Time]] = Duration

    def __new__(cls, *, seconds: float = 0, nanoseconds: float = 0, **_: object) -> Self:
        """Return the sum of *seconds* and *nanoseconds*."""
        return super().__new__(cls, round(seconds * _SECOND) + round(nanoseconds))

    @classmethod
    def from_msg(cls, msg: Any, **_: object) -> Self:
        """Return the duration in a message."""
        return cls(nanoseconds=msg.sec * _SECOND + msg.nanosec)

    @property
    def nanoseconds(self) -> int:
        """The total in nanoseconds."""
        return int(self)

    def seconds_nanoseconds(self) -> tuple[int, int]:
        """Return the whole seconds and the remaining nanoseconds."""
        return divmod(int(self), _SECOND)

    def to_msg(self) -> Any:
        """Return the duration as a message of ``builtin_interfaces``."""
        sec, nanosec = self.seconds_nanoseconds()
        return to_program(self.message(sec=sec, nanosec=nanosec))

    def __add__(self, other: int) -> Self:
        return type(self)(nanoseconds=int(self) + int(other))

    def __sub__(self, other: int) -> RclpyDuration:
        return type(self)(nanoseconds=int(self) - int(other))


class RclpyTime(RclpyDuration):
    """A point in time, in nanoseconds since the Unix epoch."""

    message = Time

    def __sub__(self, other: int) -> RclpyDuration:
        kind = RclpyDuration if isinstance(other, RclpyTime) else RclpyTime
        return kind(nanoseconds=int(self) - int(other))


class RclpyClock:
    """The clock of the graph."""

    def __init__(self, **_: object) -> None:
        """Accept a clock type, which is ignored."""

    def now(self) -> RclpyTime:
        """Return the time."""
        return RclpyTime(seconds=CONTEXT.graph.clock.now())

    def sleep_for(self, rel_time: RclpyDuration) -> bool:
        """Wait; return whether the graph is still running."""
        time.sleep(max(0, rel_time) / _SECOND)
        return CONTEXT.ok()


class RclpyRate:
    """Sleeps until the next whole period."""

    def __init__(self, frequency: float) -> None:
        self._period = 1 / frequency
        self._next = time.monotonic() + self._period

    def sleep(self) -> None:
        """Wait for the end of the period; missed ones are skipped."""
        late = time.monotonic() - self._next
        if late < 0:
            time.sleep(-late)
        self._next += self._period * (1 + max(0, int(late / self._period)))
