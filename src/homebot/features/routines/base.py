"""The common base of routines as data and of those that were exported as apps."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, MutableMapping, Sequence
from contextlib import ExitStack
from datetime import datetime, time
from functools import partial
from random import Random
from typing import Any, Final, assert_never

import anyio
from pydantic import BaseModel
from typing_extensions import TypeVar

from homebot.apps import App
from homebot.apps.jobs import Job
from homebot.apps.run_modes import HandlerRuns
from homebot.devices import Device
from homebot.devices.command_messages import CommandDevices
from homebot.devices.device import StateChange
from homebot.devices.house_view import HouseView
from homebot.devices.names import COMMAND_DEVICES, QUERY_DEVICES
from homebot.devices.query.term_messages import query_terms, query_words
from homebot.devices.services import QueryDevices, QueryDevicesRequest
from homebot.devices.wording.values import value_text
from homebot.features.routines.run import RoutineRun, RoutineRunFacts, RunPlace
from homebot.features.routines.watches import (
    MessageWatches,
    OnStart,
    TimeOfWatch,
    compared,
    follow_matches,
    holds_for,
    is_message,
    is_press,
    moment_of,
    start_watch,
    time_of,
)
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.words.conditions import (
    AnyOf,
    Chance,
    Condition,
    HouseSpan,
    LastRun,
    Matches,
    OnDays,
    SinceMoment,
    StartedBy,
    SunIs,
    TimedOut,
)
from homebot.words.message_values import Comparison
from homebot.words.steps import MAX_TURNS
from homebot.words.times import DaysAndTime, EachHour, SunMoment, SunSpan, TimeSpan, read_moment
from homebot.words.triggers import (
    AtTimeOf,
    Becomes,
    Changes,
    EachInterval,
    HomebotStarts,
    MessageComes,
    PersonMoves,
    Press,
    RobotArrival,
    SunAngle,
    Trigger,
    ValuePasses,
    capabilities_of,
    read_trigger,
)

DONE: Final = "routine.step_done"
HELD_BACK: Final = "routine.held_back"
FAILED: Final = "routine.step_failed"
STOPPED: Final = "routine.stopped"

_STARTING_S: Final = 60.0
"""Seconds after the start of homebot in which routines that begin to watch take part in it."""

_SETTLING_S: Final = 10.0
"""Seconds after which devices are known at a start."""

_RAN_AT: Final = "ran_at"

SettingsT_co = TypeVar("SettingsT_co", bound=BaseModel, default=BaseModel, covariant=True)
_Conditions = Sequence[tuple[str, Condition]]
_Timed = DaysAndTime | SunMoment | SunAngle | EachInterval | EachHour | HomebotStarts
_Watched = _Timed | Press | Changes | ValuePasses | MessageComes | AtTimeOf | PersonMoves | RobotArrival


class RoutineBase(App[SettingsT_co]):
    """Starts runs by triggers, if conditions hold.

    Conditions are checked before a running one is cancelled: a trigger that is held back changes nothing.

    Attributes:
        title: Its name in the log.
    """

    def __init__(self, node: Node, settings: SettingsT_co) -> None:
        super().__init__(node, settings)
        self.title = node.name
        self.commands = node.create_client(CommandDevices, COMMAND_DEVICES)
        self._messages = MessageWatches(node, self.devices)
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        self._chances = 0
        self._checks = HandlerRuns(node, self.start_task, "conditions", "queued", is_quiet=True)

    def watch(self, triggers: Sequence[str], on_start: Callable[[str, object], None]) -> None:
        """Call *on_start* with its text and the cause whenever one of *triggers* comes."""
        for text in triggers:
            trigger = read_trigger(text)
            if isinstance(trigger, Becomes):
                self.start_task(partial(self._follow, trigger, partial(on_start, text), self.store))
            else:
                self._watch(trigger, partial(on_start, text), text)

    def facts_of(self, trigger: str, cause: object) -> RoutineRunFacts:
        """Return the facts of a run that *trigger* starts with the change *cause*."""
        if not isinstance(cause, StateChange) or (known := HouseView.of(self.node).get(cause.device)) is None:
            return RoutineRunFacts(trigger)
        named = capabilities_of(read_trigger(trigger))
        for reading in cause.readings:
            before = known.value_before(cause, reading)
            if reading.capability in named or (not named and before != reading.value.plain()):
                return RoutineRunFacts(trigger, value_text(reading.capability, before))
        return RoutineRunFacts(trigger)

    async def wait_for(self, triggers: Sequence[Trigger]) -> int:
        """Wait for the next of *triggers*, and return its place."""
        came, places = anyio.Event(), list[int]()

        def on_start(place: int, _: object) -> None:
            places.append(place)
            came.set()

        async with anyio.create_task_group() as tasks:
            with ExitStack() as watches:
                for place, trigger in enumerate(triggers):
                    if isinstance(trigger, Becomes):
                        tasks.start_soon(self._follow, trigger, partial(on_start, place), {})
                    else:
                        watches.callback(self._watch(trigger, partial(on_start, place)))
                await came.wait()
            tasks.cancel_scope.cancel()
        return places[0]

    async def fitting(self, devices: str) -> tuple[str, ...]:
        """Return the ids of the devices that the query *devices* finds now, in the order of their names."""
        answer = await self._query.call(QueryDevicesRequest(query=query_words(devices), limit=MAX_TURNS))
        if answer.total > MAX_TURNS:
            self.log_failure(f"for each {devices}", f"{answer.total:,} devices fit; the limit is {MAX_TURNS}")
        found = [result.device for result in answer.results]
        return tuple(device.id for device in sorted(found, key=lambda device: (device.name, device.id)))

    def start_if(
        self, conditions: _Conditions, start: Callable[[object], object], cause: object, started_by: str
    ) -> None:
        """Call *start* with the *cause* if *conditions* hold in a run *started_by* this trigger."""
        if conditions:
            self._checks.start(partial(self._check, conditions, start, cause, RoutineRunFacts(started_by)), cause)
        else:
            start(cause)

    async def unmet(self, conditions: _Conditions, facts: RoutineRunFacts) -> str:
        """Return the first of *conditions* that does not hold in a run; empty if all do."""
        for text, condition in conditions:
            if not await self._holds(condition, facts):
                return text
        return ""

    async def keep(self, run: RoutineRun, place: RunPlace, before: dict[str, list[Any]]) -> None:
        """Store how far *run* is, for a restart."""

    def record(self, text: str) -> None:
        """Add a line to the last runs."""

    def begin_run(self) -> None:
        """Record that a run begins now."""
        self.store[_RAN_AT] = self.clock.now()

    def log_done(self, step: str) -> None:
        """Log that a step that no device's journal knows was done."""
        self.record(f"done: {step!r}")
        self.log_limited(DONE, f"{self.title}: {step!r} is done")

    def log_failure(self, step: str, problem: str) -> None:
        """Log that a step failed; the next ones follow all the same."""
        self.record(f"{step!r} failed: {problem}")
        self.log_limited(FAILED, f"{self.title}: {step!r} failed: {problem}")

    def log_stop(self, step: str, problem: str) -> None:
        """Log that a run ended in a step, after which it does not go on."""
        text = f"stopped in {step}: {problem}"
        self.record(text)
        self.log.warning(STOPPED, message=f"{self.title} {text}")

    def _watch(self, trigger: _Watched, on_start: OnStart, name: str | None = None) -> Callable[[], None]:
        """Call *on_start* with the cause whenever *trigger* comes, until the returned function is called."""

        def start() -> None:
            on_start(CURRENT_CAUSE.get())

        match trigger:
            case MessageComes():
                return self._messages.add(trigger, on_start)
            case AtTimeOf():
                call_at = partial(self._daily_at, start, name or trigger.text)
                return TimeOfWatch(self.node, trigger, self.context.zone, call_at).close
            case Press() | Changes() | ValuePasses() | PersonMoves() | RobotArrival():
                return start_watch(self.node, trigger, on_start)
            case _:
                return self._watch_time(trigger, start, name)

    def _watch_time(self, trigger: _Timed, start: Callable[[], None], name: str | None) -> Callable[[], None]:
        match trigger:
            case DaysAndTime():
                return self.daily(trigger.time, start, days=trigger.days, name=name).cancel
            case SunMoment():
                return self.at(trigger.event, start, offset=trigger.offset, name=name).cancel
            case SunAngle():
                return self._jobs().at_sun_angle(trigger, start, name).cancel
            case HomebotStarts():
                is_start = self.clock.now() - self.context.began_at < _STARTING_S and self.context.rehearse is None
                return self.after(_SETTLING_S, start, name=name).cancel if is_start else partial(_cancel, ())
            case EachInterval():
                return self.every(trigger.length, start, name=name).cancel
            case EachHour():
                hours = [
                    self.daily(f"{hour}:{trigger.minute:02}", start, name=name and f"{name} ({hour})")
                    for hour in range(24)
                ]
                return partial(_cancel, hours)

    def _daily_at(self, start: Callable[[], None], name: str, at: str) -> Callable[[], None]:
        clock, day = read_moment(at)

        def start_on_day() -> None:
            if day in {None, self.now().date()}:
                start()

        days = "" if day is None else f"{day:%d %B}"
        return self.daily(clock, start_on_day, days=days, name=f"{name} at {at}").cancel

    async def _follow(self, trigger: Becomes, on_start: OnStart, store: MutableMapping[str, Any]) -> None:
        async for match in follow_matches(self.node, trigger, store, is_new=True):
            on_start(match.cause)

    async def _check(
        self, conditions: _Conditions, start: Callable[[object], object], cause: object, facts: RoutineRunFacts
    ) -> None:
        if text := await self.unmet(conditions, facts):
            self.record(f"held back: not {text!r}")
            self.log_limited(HELD_BACK, f"{self.title} did not run: {text!r} does not hold")
        else:
            start(cause)

    async def _holds(self, condition: Condition, facts: RoutineRunFacts) -> bool:
        match condition:
            case SunIs() | SunAngle() | OnDays() | TimeSpan() | SunSpan() | LastRun():
                return self._is_time(condition)
            case Matches() if condition.state.lasting:
                devices = await self.devices.find()
                return holds_for(
                    condition.state,
                    devices,
                    self.clock.now(),
                    is_none=condition.is_none,
                    is_recent=condition.is_recent,
                )
            case Matches():
                state = condition.state
                query = query_words(state.words) or query_terms(state.query)
                answer = await self._query.call(QueryDevicesRequest(query=query, limit=1))
                return bool(answer.results) is not condition.is_none
            case Press():
                return is_press(HouseView.of(self.node), condition, CURRENT_CAUSE.get())
            case MessageComes():
                cause = CURRENT_CAUSE.get()
                is_that = isinstance(cause, tuple) and is_message(condition, cause[-1])
                return is_that is not condition.is_denied
            case StartedBy() | TimedOut():
                return _is_of_run(condition, facts)
            case Comparison():
                holds = compared(condition, await self.devices.find(), self.sun_angle)
                return condition.is_denied if holds is None else holds
            case HouseSpan():
                return _is_within(condition, await self.devices.find(), self.now().time())
            case SinceMoment():
                at = moment_of(condition.moment, await self.devices.find(), self.context.zone)
                return at is not None and (self.clock.now() - at > condition.seconds) is condition.is_over
            case Chance():
                self._chances += 1
                seed = f"{self.title} {self.clock.now()} {self._chances}"
                return not Random(seed).randrange(condition.count)  # noqa: S311 - no secret
            case AnyOf():
                for alternative in condition.conditions:
                    if await self._holds(alternative, facts):
                        return True
                return False
            case _:
                assert_never(condition)

    def _is_time(self, condition: SunIs | SunAngle | OnDays | TimeSpan | SunSpan | LastRun) -> bool:
        """Return whether *condition*, which asks no device, holds now."""
        match condition:
            case SunIs():
                return self.sun_is_up() is condition.is_up
            case SunAngle():
                return (self.sun_angle(condition.is_azimuth) > condition.degrees) is condition.is_above
            case OnDays():
                return condition.days.has(self.now().date())
            case TimeSpan():
                return condition.has(self.now().time())
            case SunSpan():
                span = condition.on_day(self._sun_time)
                return span is not None and span.has(self.now().time())
            case LastRun():
                now = self.now()
                limit = now.replace(hour=0, minute=0, second=0, microsecond=0).timestamp()
                if condition.seconds is not None:
                    limit = now.timestamp() - condition.seconds
                return (self.store.get(_RAN_AT, -math.inf) < limit) is condition.is_over

    def sun_angle(self, is_azimuth: bool) -> float:  # noqa: FBT001 - values of the sun call it
        """Return the azimuth of the sun now, else its elevation, in degrees."""
        from homebot.apps.sun import sun_angle  # noqa: PLC0415 - astral is for routines that ask

        home = self.context
        return sun_angle(self.clock.now(), home.latitude, home.longitude, is_azimuth=is_azimuth)

    def _sun_time(self, moment: SunMoment) -> time | None:
        """Return the time of *moment* today, or the nearest if it is on another day; None if there is none."""
        from homebot.apps.sun import sun_time  # noqa: PLC0415 - astral is for routines that ask

        home, today = self.context, self.now().date()
        at = sun_time(moment.event, home.latitude, home.longitude, moment.seconds).on(today, home.zone)
        if at is None:
            return None
        nearest = datetime.fromtimestamp(at, home.zone)
        if nearest.date() == today:
            return nearest.time()
        return time.max if nearest.date() > today else time(microsecond=1)


def _is_within(span: HouseSpan, devices: Sequence[Device], now: time) -> bool:
    """Return whether *now* is between two times of the house; False if one is unknown."""
    begin, end = time_of(span.begin, devices), time_of(span.end, devices)
    return begin is not None and end is not None and TimeSpan(begin, end).has(now)


def _is_of_run(condition: StartedBy | TimedOut, facts: RoutineRunFacts) -> bool:
    if isinstance(condition, TimedOut):
        return facts.has_timed_out is condition.is_so
    text = facts.ended_by if condition.of_wait else facts.started_by
    is_that = bool(text) and read_trigger(text) == condition.trigger
    return is_that is not condition.is_other


def _cancel(jobs: Iterable[Job]) -> None:
    for job in jobs:
        job.cancel()
