"""The clock that is passed to everything that needs the time, time slices for long work, and time zones.

It has two readings: :meth:`Clock.monotonic` for durations, which never goes back, and :meth:`Clock.now` for time stamps
that leave the process. In a test both advance together; on a real computer ``now`` also follows changes of the
system clock, and includes time asleep.
"""

import asyncio
import os
import time
import zoneinfo
from collections.abc import Callable, Generator
from contextvars import ContextVar
from datetime import UTC, datetime, tzinfo
from functools import lru_cache
from pathlib import Path
from typing import Final, Protocol, TypeVar, final

import anyio.lowlevel

from homebot.errors import UsageError

T = TypeVar("T")


class Clock(Protocol):
    """A source of time."""

    def monotonic(self) -> float:
        """Return seconds since an arbitrary start; never goes back."""
        ...

    def now(self) -> float:
        """Return seconds since the Unix epoch, UTC."""
        ...


@final
class LoopClock:
    """The clock of the running event loop; under a virtual-time loop this is virtual time.

    Args:
        epoch: The initial reading of :meth:`now`, in seconds since the Unix epoch; from then on it advances with the
            loop. By default it always is the computer's time, even if that is set or the computer sleeps.

    Attributes:
        monotonic: Returns seconds of the event loop's time. Called so often that it is the loop's own function, or the
            function that the loop calls.
        now: Returns seconds since the Unix epoch, UTC; also called often.
        asleep: Returns the seconds for which the computer was suspended, which :meth:`monotonic` leaves out.
    """

    def __init__(self, epoch: float | None = None) -> None:
        loop = asyncio.get_running_loop()
        is_real = type(loop).time is asyncio.BaseEventLoop.time
        self.monotonic = time.monotonic if is_real else loop.time
        self._offset = (time.time() if epoch is None else epoch) - self.monotonic()
        self.now = time.time if epoch is None and is_real else lambda: self._offset + self.monotonic()
        self.asleep = _seconds_asleep if is_real and _SINCE_BOOT is not None else float


@final
class ManualClock:
    """A clock that only advances when told to, for tests of code without an event loop."""

    def __init__(self, start: float = 0.0) -> None:
        self._now = start

    def monotonic(self) -> float:
        """Return seconds; equal to :meth:`now`."""
        return self._now

    def now(self) -> float:
        """Return seconds since the Unix epoch."""
        return self._now

    def advance(self, seconds: float) -> None:
        """Move the clock forward by *seconds*.

        Raises:
            UsageError: *seconds* is below 0.
        """
        if seconds < 0:
            raise UsageError(f"a clock does not go back: {seconds}")
        self._now += seconds


SLICE = 0.005
"""Seconds of one slice: the cost of a piece of work is unknown, as a device may have hundreds of parts."""


@final
class TimeSlice:
    """The current time slice of one task, which begins when it is created.

    Call ``if slice.is_over: await slice.pause()`` after each piece of work.
    """

    def __init__(self, clock: Clock) -> None:
        self._monotonic = clock.monotonic
        self._ends = clock.monotonic() + SLICE

    @property
    def is_over(self) -> bool:
        """True if another task should have its turn."""
        return self._monotonic() >= self._ends

    async def pause(self) -> None:
        """Give all other tasks a turn, and begin the next slice."""
        await anyio.lowlevel.checkpoint()
        self._ends = self._monotonic() + SLICE

    async def do(self, work: Generator[None, None, T]) -> T:
        """Run *work* with pauses between its steps, and return its result."""
        while True:
            try:
                next(work)
            except StopIteration as done:
                result: T = done.value
                return result
            if self.is_over:
                await self.pause()


_SINCE_BOOT: Final[int | None] = getattr(time, "CLOCK_BOOTTIME", None)  # only on Linux


def _seconds_asleep() -> float:
    assert _SINCE_BOOT is not None  # noqa: S101 - for the type checker
    return time.clock_gettime(_SINCE_BOOT) - time.monotonic()


home_time: Final = ContextVar[Callable[[], datetime] | None]("home_time", default=None)
"""Returns the current time in the zone of the home, for templates of devices; None outside of a running homebot."""

_ZONE_OF_COMPUTER: Final = Path("/etc/localtime")
_ZONES: Final = "/zoneinfo/"


def read_zone(name: str, computer: Path = _ZONE_OF_COMPUTER) -> tzinfo:
    """Read the time zone with the IANA name *name*, such as ``Europe/Berlin``; the computer's if it is empty.

    Args:
        computer: The file of the computer's zone: a link into a folder of zones, or a copy.

    Raises:
        UsageError: There is no such zone.
    """
    return _read_zone(name, computer)


@lru_cache(maxsize=16)
def _read_zone(name: str, computer: Path) -> tzinfo:
    for zone in (name,) if name else _names_of_computer(computer):
        try:
            return zoneinfo.ZoneInfo(zone)
        except (zoneinfo.ZoneInfoNotFoundError, ValueError, OSError):  # OSError: the name is that of a folder of zones
            continue
    if name:
        raise UsageError(f"there is no time zone {name!r}")
    try:
        with computer.open("rb") as file:
            return zoneinfo.ZoneInfo.from_file(file)
    except (OSError, ValueError):
        return UTC


def _names_of_computer(file: Path) -> tuple[str, ...]:
    given = os.environ.get("TZ", "").lstrip(":")
    return given, given.partition(_ZONES)[2], str(file.resolve()).partition(_ZONES)[2]


def zone_name(name: str, computer: Path = _ZONE_OF_COMPUTER) -> str:
    """Return the IANA name of the zone *name*, or of the computer's zone if empty; empty if that has none."""
    return getattr(read_zone(name, computer), "key", None) or ""
