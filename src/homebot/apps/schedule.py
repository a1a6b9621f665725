"""The schedule of one app: its jobs by name, called when they are due."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterable
from dataclasses import dataclass
from datetime import date, datetime, time, timedelta, tzinfo
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Protocol, TypeAlias, final

import anyio

from homebot.apps.jobs import Due, Interval, Job, JobFacts, Times, WallJob
from homebot.apps.run_modes import HandlerRuns, RunHandler, RunMode, check_handler
from homebot.errors import UsageError
from homebot.graph.current_cause import CURRENT_CAUSE, TimerCause
from homebot.units import MAX_WAIT, parse_duration
from homebot.words.days import CalendarDays, read_days
from homebot.words.times import MAX_OFFSET_S, read_time

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Coroutine

    from structlog.typing import FilteringBoundLogger

    from homebot.apps.context import AppContext
    from homebot.apps.store import Store
    from homebot.clock import Clock
    from homebot.graph import Node
    from homebot.words.triggers import SunAngle


JOB_SKIPPED: Final = "app.job_skipped"
MAX_JOBS: Final = 1000
MAX_CATCH_UP: Final = 31 * 86_400.0
_TIMERS, _DAYS = "_timers", "_days"
_GRACE: Final = 60.0  # seconds by which any durable timer may be late
_OWN: Final = "homebot.apps."

Length: TypeAlias = str | float | timedelta
"""A length of time: text such as ``2m``, seconds, or a timedelta."""


class _JobOwner(Protocol):
    """The owner of jobs, such as :class:`homebot.App`."""

    @property
    def node(self) -> Node: ...

    @property
    def clock(self) -> Clock: ...

    @property
    def log(self) -> FilteringBoundLogger: ...

    @property
    def context(self) -> AppContext: ...

    @property
    def store(self) -> Store: ...

    def start_task(self, function: Callable[[], Coroutine[object, object, object]]) -> None: ...


@final
class Schedule:
    """The jobs of *app*; see the methods of the same names in :class:`homebot.App`."""

    def __init__(self, app: _JobOwner) -> None:
        self._app = app
        self._clock = app.clock
        self._jobs: dict[str, Job] = {}
        self._resumed: set[str] = set()
        self._is_working = False
        self._changed = anyio.Event()

    @property
    def jobs(self) -> tuple[Job, ...]:
        """The jobs, in the order in which they were created."""
        return tuple(self._jobs.values())

    def resume(self) -> None:
        """Resume the durable timers of an earlier run; one that is too late, or lacks its method, is dropped."""
        for name, kept in self._kept(_TIMERS).items():
            handler = getattr(self._app, str(kept.get("handler")), None)
            left = float(kept["due"]) - self._clock.now()
            late, delay = max(0.0, -left), min(max(0.0, left), float(kept["delay"]))
            if handler is None or late > max(_GRACE, float(kept["catch_up"])):
                self._store(_TIMERS, name, None)
                is_late = f"it was due {_duration(late)} ago"
                self._skipped(name, is_late if handler else f"its method {kept.get('handler')} is gone")
                continue
            args = kept.get("args", [])
            try:
                check_handler(handler, *args)
            except UsageError as exc:
                self._store(_TIMERS, name, None)
                self._skipped(name, str(exc))
                continue
            text = str(kept.get("text", f"after {kept['delay']:g} s"))
            job = self._interval(name, text, partial(handler, *args), delay, None)
            job.late = late
            self._resumed.add(name)
            self._add(job)

    def after(
        self,
        delay: Length,
        handler: Callable[..., Awaitable[object] | None],
        args: tuple[object, ...],
        name: str | None,
        *,
        durable: bool,
        catch_up: Length,
    ) -> Job:
        """See :meth:`homebot.App.after`."""
        seconds, late = parse_duration(delay, "delay", most=MAX_WAIT), _catch_up(catch_up)
        text = f"after {delay if isinstance(delay, str) else f'{seconds:g} s'}"
        method = getattr(handler, "__name__", "")
        if durable:
            if getattr(handler, "__self__", None) is not self._app or not name or type(name) is not str:
                raise UsageError(
                    "a durable timer needs a name, and a method of the app as its handler: "
                    "it is found by them after a restart"
                )
            if (resumed := self._resume_timer(name)) is not None:
                return resumed
        elif late:
            raise UsageError("catch_up is for a durable timer: give durable=True too")
        check_handler(handler, *args)
        job = self._interval(
            self._name(name, handler, text, is_timer=True), text, partial(handler, *args), seconds, None
        )
        due = self._clock.now() + seconds
        kept = {"handler": method, "args": args, "due": due, "delay": seconds, "catch_up": late, "text": text}
        self._store(_TIMERS, job.name, kept if durable else None)
        self._add(job)
        return job

    def _resume_timer(self, name: str) -> Job | None:
        """Return the resumed timer *name* if this is its first request by a starting app; None otherwise."""
        is_first = name in self._resumed
        self._resumed.discard(name)
        return self._jobs.get(name) if is_first and CURRENT_CAUSE.get() is None else None

    def every(self, period: Length, handler: RunHandler, name: str | None, offset: Length, mode: RunMode) -> Job:
        """See :meth:`homebot.App.every`."""
        seconds = parse_duration(period, "period", most=MAX_WAIT)
        if not seconds:
            raise UsageError("period: must be above 0")
        text = f"every {period if isinstance(period, str) else f'{seconds:g} s'}"
        begin = seconds + parse_duration(offset, "offset", most=MAX_WAIT)
        job = self._interval(self._name(name, handler, text), text, handler, begin, seconds, mode)
        return self._add(job)

    def daily(self, at: str, handler: RunHandler, days: str, name: str | None, catch_up: Length, mode: RunMode) -> Job:
        """See :meth:`homebot.App.daily`."""
        times = TimeOfDay(read_time(at), read_days(days))
        text = f"daily at {at}" if not days else f"daily at {at} on {days}"
        return self._add_wall(times, text, handler, name, catch_up, mode)

    def at(
        self,
        event: str,
        handler: RunHandler,
        offset: Length,
        jitter: Length,
        name: str | None,
        catch_up: Length,
        mode: RunMode,
    ) -> Job:
        """See :meth:`homebot.App.at`."""
        from homebot.apps.sun import sun_time  # noqa: PLC0415 - astral takes 40 ms

        home, seconds = self._app.context, _to_signed("offset", offset)
        spread = _seconds("jitter", jitter, MAX_OFFSET_S, "12 hours")
        times = sun_time(event, home.latitude, home.longitude, seconds)
        shown = "" if not seconds else f" {offset if isinstance(offset, str) else f'{seconds:+g} s'}"
        return self._add_wall(times, f"{event}{shown}", handler, name, catch_up, mode, spread)

    def at_sun_angle(self, angle: SunAngle, handler: RunHandler, name: str | None) -> Job:
        """Call *handler* each day when the sun comes above or below an elevation, or past an azimuth."""
        from homebot.apps.sun import angle_time  # noqa: PLC0415 - astral takes 40 ms

        home = self._app.context
        times = angle_time(angle, home.latitude, home.longitude)
        way = "comes past" if angle.is_azimuth else "rises above" if angle.is_above else "falls below"
        text = f"the sun {way} {angle.degrees:g}°"
        return self._add_wall(times, text, handler, name, 0, "single")

    def _read_day(self, name: str) -> date | None:
        kept = self._kept(_DAYS).get(name)
        return None if kept is None else date.fromisoformat(kept)

    def _write_day(self, name: str, day: date) -> None:
        self._store(_DAYS, name, day.isoformat())

    def _add_wall(
        self,
        times: Times,
        text: str,
        handler: RunHandler,
        name: str | None,
        catch_up: Length,
        mode: RunMode,
        jitter: float = 0.0,
    ) -> Job:
        late = _catch_up(catch_up)
        facts = self._facts(self._name(name, handler, text), text, handler, mode)
        return self._add(WallJob(facts, times, self._read_day, self._write_day, late, jitter))

    def _interval(
        self,
        name: str,
        text: str,
        handler: RunHandler,
        delay: float,
        period: float | None,
        mode: RunMode = "single",
    ) -> Interval:
        return Interval(self._facts(name, text, handler, mode), self._elapsed() + delay, period)

    def _facts(self, name: str, text: str, handler: RunHandler, mode: RunMode) -> JobFacts:
        check_handler(handler)
        runs = HandlerRuns(self._app.node, self._app.start_task, f"job {name}", mode)
        zone = self._app.context.zone
        return JobFacts(name, text, _calling_line(), handler, runs, self._clock, self._elapsed, zone, self._forget)

    def _elapsed(self) -> float:
        return self._clock.monotonic() + self._app.context.asleep()

    def _name(self, name: str | None, handler: RunHandler, text: str, *, is_timer: bool = False) -> str:
        """Return the name of a new job, which may exist already only if a timer replaces a timer."""
        if name is None:
            function = handler.func if isinstance(handler, partial) else handler
            base = f"{getattr(function, '__name__', '').strip('<>').replace('lambda', '')} {text}".strip()
            return next(candidate for candidate in _number(base) if candidate not in self._jobs)
        if type(name) is not str or not name:
            raise UsageError(f"name: {name!r:.60} is not a text of one character or more")
        other = self._jobs.get(name)
        if other is not None and not (is_timer and _is_timer(other)):
            raise UsageError(f"two jobs are named {name!r}: at {other.where} and at {_calling_line()}; rename one")
        return name

    def _add(self, job: Job) -> Job:
        if len(self._jobs) >= MAX_JOBS:
            raise UsageError(f"an app has at most {MAX_JOBS:,} jobs; is {job.name} created again and again?")
        self._jobs[job.name] = job
        self._changed.set()
        if not self._is_working:
            self._app.start_task(self._work)
            self._is_working = True
        return job

    def _forget(self, job: Job) -> None:
        if self._jobs.get(job.name) is job:
            del self._jobs[job.name]
            self._store(_TIMERS if _is_timer(job) else _DAYS, job.name, None)
            self._changed.set()

    async def _work(self) -> None:
        try:
            while self._jobs:
                self._changed = anyio.Event()
                for job in self.jobs:
                    if (due := job.look()) is not None:
                        self._call(job, due)
                nap = min((job.nap() for job in self._jobs.values()), default=math.inf)
                with anyio.move_on_after(0 if not self._jobs else nap):
                    await self._changed.wait()
        finally:
            self._is_working = False

    def _call(self, job: Job, due: Due) -> None:
        if _is_timer(job):
            self._forget(job)
        if due.is_missed:
            self._skipped(job.name, f"it was due {_duration(due.late)} ago")
            return
        now = self._clock.now()
        text = f"{job.text}, {_duration(due.late)} late" if due.late > _GRACE else job.text
        job.runs.start(job.facts.handler, TimerCause(f"timer-{job.name}-{now:.0f}", text, now))

    def _skipped(self, name: str, why: str) -> None:
        self._app.log.warning(JOB_SKIPPED, message=f"the job {name} is skipped: {why}", job=name)

    def _kept(self, key: str) -> dict[str, Any]:
        return dict(self._app.store.get(key, {}))

    def _store(self, key: str, name: str, value: object) -> None:
        kept = self._kept(key)
        if value is None and name not in kept:
            return
        self._app.store[key] = {kept_name: kept[kept_name] for kept_name in kept if kept_name != name} | (
            {} if value is None else {name: value}
        )


def _is_timer(job: Job) -> bool:
    return isinstance(job, Interval) and job.period is None


def _calling_line() -> str:
    """Return the line of the app's own code that is running."""
    frame = sys._getframe(1)  # noqa: SLF001 - a whole traceback would cost a hundred times as much
    while frame.f_back is not None and frame.f_globals.get("__name__", "") in _MODULES:
        frame = frame.f_back
    return f"{Path(frame.f_code.co_filename).name}:{frame.f_lineno}"


_MODULES: Final = frozenset({f"{_OWN}schedule", f"{_OWN}base"})


def _number(base: str) -> Iterable[str]:
    yield base
    yield from (f"{base} ({number})" for number in range(2, MAX_JOBS + 2))


def _to_signed(key: str, length: Length) -> float:
    """Return seconds that may be negative, at most 12 hours, so that each event of the sun stays on its own day."""
    if isinstance(length, str):
        text = length.strip()
        sign, length = (-1.0 if text.startswith("-") else 1.0), text[text[:1] in ("-", "+") :]
    else:
        seconds = length.total_seconds() if isinstance(length, timedelta) else length
        sign, length = (-1.0, -seconds) if type(seconds) in (int, float) and seconds < 0 else (1.0, seconds)
    return sign * _seconds(key, length, MAX_OFFSET_S, "12 hours")


def _seconds(key: str, length: Length, most: float, most_text: str) -> float:
    seconds = parse_duration(length, key)
    if seconds > most:
        raise UsageError(f"{key}: {length} is more than {most_text}")
    return seconds


def _catch_up(length: Length) -> float:
    return _seconds("catch_up", length, MAX_CATCH_UP, "31 days")


def _duration(seconds: float) -> str:
    hours, minutes = int(seconds // 3600), int(seconds % 3600 // 60)
    return f"{hours} h {minutes} min" if hours else f"{minutes} min"


@final
@dataclass(frozen=True, slots=True)
class TimeOfDay:
    """A time on some days."""

    time: time
    days: CalendarDays

    def on(self, day: date, zone: tzinfo) -> float | None:
        """Return the moment on *day*, in seconds since the Unix epoch; None if the day is not among its days."""
        return moment_of(day, self.time, zone) if self.days.has(day) else None


def moment_of(day: date, at: time, zone: tzinfo) -> float:
    """Return the moment of *at* on *day* in *zone*, in seconds since the Unix epoch.

    A time that a day lacks becomes the end of the gap; of a time that occurs twice, the first is used.
    """
    wanted = datetime.combine(day, at, zone)
    moment = wanted.timestamp()
    if datetime.fromtimestamp(moment, zone).time() == at:
        return moment
    low, high = wanted.replace(fold=1).timestamp(), moment  # around a clock change
    before = datetime.fromtimestamp(low, zone).utcoffset()
    while high - low > 1:
        middle = (low + high) // 2
        if datetime.fromtimestamp(middle, zone).utcoffset() == before:
            low = middle
        else:
            high = middle
    return high
