"""Jobs of an app: when each is due next, by elapsed time or by time of day."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from datetime import date, datetime, timedelta, tzinfo
from random import Random
from typing import Final, NamedTuple, Protocol, final

from homebot.apps.run_modes import HandlerRuns, RunHandler
from homebot.clock import Clock

EARLIEST: Final = 1_735_689_600.0
"""2025-01-01: an earlier clock is not set yet, as on a Raspberry Pi without network."""
MAX_NAP: Final = 60.0
"""Seconds within which a clock change or a sleep of the computer is noticed; no run is later than that."""
_STEP_BACK: Final = 1.0
_SHORTEST: Final = 0.001
_SEARCHED: Final = 400


class Due(NamedTuple):
    """A due call: since how many seconds, and whether it is too late."""

    late: float = 0.0
    is_missed: bool = False


@final
@dataclass(frozen=True, slots=True, eq=False)
class JobFacts:
    """Facts that are common to all jobs.

    Attributes:
        text: When it is called, such as ``daily at 22:00``.
        elapsed: Returns the seconds since an arbitrary start, including sleep of the computer.
    """

    name: str
    text: str
    where: str
    handler: RunHandler
    runs: HandlerRuns
    clock: Clock
    elapsed: Callable[[], float]
    zone: tzinfo
    forget: Callable[[Job], None]


@dataclass(eq=False)
class Job(ABC):
    """A job of an app; :meth:`cancel` ends it, :attr:`next` is the time of its next call."""

    facts: JobFacts

    def __post_init__(self) -> None:
        self.name, self.text, self.where = self.facts.name, self.facts.text, self.facts.where
        self.runs, self.clock, self.zone = self.facts.runs, self.facts.clock, self.facts.zone

    @property
    def next(self) -> datetime | None:
        """The time of its next call, in the home's zone; None if unknown, or if it is not called any more."""
        at = None if self.runs.trouble else self.next_at()
        return None if at is None else datetime.fromtimestamp(at, self.zone)

    @property
    def note(self) -> str:
        """The reason why it will not be called soon; empty otherwise."""
        return self.runs.trouble

    def cancel(self) -> None:
        """End the job; a running call continues. Idempotent."""
        self.facts.forget(self)

    @abstractmethod
    def next_at(self) -> float | None:
        """Return the time of the next call, in seconds since the Unix epoch."""

    @abstractmethod
    def look(self) -> Due | None:
        """Return the due call, once."""

    @abstractmethod
    def nap(self) -> float:
        """Return the seconds until the next :meth:`look`."""


@dataclass(eq=False)
@final
class Interval(Job):
    """A job after an elapsed time, once or repeatedly.

    Attributes:
        due: When it is due, by ``facts.elapsed``.
        period: Seconds between two calls; None for one call.
        late: Seconds by which it was due while homebot was stopped.
    """

    due: float
    period: float | None = None
    late: float = 0.0

    def next_at(self) -> float | None:
        """See above."""
        return self.clock.now() + max(0.0, self.due - self.facts.elapsed())

    def look(self) -> Due | None:
        """See above; of several missed calls one is due, and the next keeps the old rhythm."""
        over = self.facts.elapsed() - self.due
        if over < 0:
            return None
        if self.period is not None:
            self.due += (over // self.period + 1) * self.period
        return Due(self.late)

    def nap(self) -> float:
        """See above."""
        return min(MAX_NAP, max(_SHORTEST, self.due - self.facts.elapsed()))


class Times(Protocol):
    """At most one moment for each day."""

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if there is none."""


@dataclass(eq=False)
@final
class WallJob(Job):
    """A job at a time of day.

    It is called once a day, even if the clock is set back.

    Attributes:
        times: The moment of each day.
        catch_up: Seconds by which a call may be late.
        jitter: Seconds by which each call is earlier or later, the same at each look.
        read_day: Returns the day of its last call, perhaps in an earlier run, by its name.
        write_day: Saves the day of its last call.
    """

    times: Times
    read_day: Callable[[str], date | None]
    write_day: Callable[[str, date], None]
    catch_up: float = 0.0
    jitter: float = 0.0

    def __post_init__(self) -> None:
        super().__post_init__()
        self._next: tuple[date, float] | None = None
        self._looked = -math.inf
        self._skipped: tuple[float, date] | None = None  # a moment, and the day that was handled before

    @property
    def note(self) -> str:
        """See above."""
        now = self.clock.now()
        if self.runs.trouble or now < EARLIEST:
            return self.runs.trouble or "waits until the clock is set"
        days = None if self._next is None else (self._next[0] - self._day(now)).days
        is_long = days is None or (days > 1 and self._on(self._day(now)) is None and "daily" not in self.text)
        return f"no {self.text.split()[0]} today" if is_long else ""

    def next_at(self) -> float | None:
        """See above."""
        return None if self._next is None else self._next[1]

    def nap(self) -> float:
        """See above."""
        left = MAX_NAP if self._next is None else self._next[1] - self.clock.now()
        return min(MAX_NAP, max(_SHORTEST, left))

    def look(self) -> Due | None:
        """See above; of several missed calls the last one may be due."""
        now, before = self.clock.now(), self._looked
        if now < EARLIEST:
            self._next = None
            return None
        self._looked = now
        if self._next is not None and before - _STEP_BACK <= now < self._next[1]:
            return None
        last, handled = self._last(now), self.read_day(self.name)
        due = None
        if self._skipped is not None and now < self._skipped[0]:  # by a clock that was ahead
            handled, self._skipped = self._skipped[1], None
            self.write_day(self.name, handled)
        if handled is None or handled > self._day(now) + timedelta(days=1):  # new, or the clock was a day ahead
            handled = self._day(now) - timedelta(days=2) if last is None else last[0]
            self.write_day(self.name, handled)
        elif last is not None and last[0] > handled:
            late = now - last[1]
            due = Due(late, is_missed=late > max(self.catch_up, MAX_NAP))
            self._skipped = (last[1], handled) if due.is_missed else None
            handled = last[0]
            self.write_day(self.name, handled)
        self._next = self._first_after(handled, now)
        return due

    def _last(self, now: float) -> tuple[date, float] | None:
        back = 2 + int(self.catch_up // 86_400)
        for ahead in range(1, -back - 1, -1):
            day = self._day(now) + timedelta(days=ahead)
            if (at := self._on(day)) is not None and at <= now:
                return day, at
        return None

    def _first_after(self, handled: date, now: float) -> tuple[date, float] | None:
        begin = max(handled, self._day(now) - timedelta(days=2))
        for ahead in range(1, _SEARCHED):
            day = begin + timedelta(days=ahead)
            if (at := self._on(day)) is not None and at > now:
                return day, at
        return None

    def _on(self, day: date) -> float | None:
        at = self.times.on(day, self.zone)
        if at is None or not self.jitter:
            return at
        return at + Random(f"{self.name} {day}").uniform(-self.jitter, self.jitter)  # noqa: S311 - no secret

    def _day(self, at: float) -> date:
        return datetime.fromtimestamp(at, self.zone).date()
