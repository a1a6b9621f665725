"""The common base of routines as data and of those that were exported as apps."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from datetime import datetime, time
from functools import partial
from typing import Any, Final, assert_never

from pydantic import BaseModel
from typing_extensions import TypeVar

from homebot.apps import App
from homebot.apps.run_modes import HandlerRuns
from homebot.devices.command_messages import CommandDevices
from homebot.devices.house_view import HouseView
from homebot.devices.names import COMMAND_DEVICES, QUERY_DEVICES
from homebot.devices.query.term_messages import query_terms, query_words
from homebot.devices.services import QueryDevices, QueryDevicesRequest
from homebot.features.routines.run import RoutineRun, RunPlace
from homebot.features.routines.watches import (
    ArrivalWatch,
    PersonWatch,
    PressWatch,
    ValueWatch,
    begun,
    holds_for,
    is_press,
)
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.words.conditions import AnyOf, Condition, LastRun, Matches, OnDays, SunIs
from homebot.words.times import DaysAndTime, EachHour, SunMoment, SunSpan, TimeSpan
from homebot.words.triggers import Becomes, Changes, EachInterval, PersonMoves, Press, RobotArrival, read_trigger

DONE: Final = "routine.step_done"
HELD_BACK: Final = "routine.held_back"
FAILED: Final = "routine.step_failed"
STOPPED: Final = "routine.stopped"

_RAN_AT: Final = "ran_at"

SettingsT_co = TypeVar("SettingsT_co", bound=BaseModel, default=BaseModel, covariant=True)
_Conditions = Sequence[tuple[str, Condition]]


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
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        self._checks = HandlerRuns(node, self.start_task, "conditions", "queued", is_quiet=True)

    def watch(self, triggers: Sequence[str], on_start: Callable[[object], None]) -> None:
        """Call *on_start* with the cause whenever one of *triggers* comes."""

        def start() -> None:
            on_start(CURRENT_CAUSE.get())

        for text in triggers:
            trigger = read_trigger(text)
            match trigger:
                case DaysAndTime():
                    self.daily(trigger.time, start, days=trigger.days, name=text)
                case SunMoment():
                    self.at(trigger.event, start, offset=trigger.offset, name=text)
                case EachInterval():
                    self.every(trigger.length, start, name=text)
                case EachHour():
                    for hour in range(24):
                        self.daily(f"{hour}:{trigger.minute:02}", start, name=f"{text} ({hour})")
                case Becomes():
                    self.start_task(partial(self._follow, trigger, on_start))
                case Press():
                    PressWatch(self.node, trigger, on_start)
                case Changes():
                    ValueWatch(self.node, trigger, on_start)
                case PersonMoves():
                    PersonWatch(self.node, trigger, on_start)
                case RobotArrival():
                    ArrivalWatch(self.node, trigger, on_start)
                case _:
                    assert_never(trigger)

    def start_if(self, conditions: _Conditions, start: Callable[[object], object], cause: object) -> None:
        """Call *start* with the *cause* if *conditions* hold."""
        if conditions:
            self._checks.start(partial(self._check, conditions, start, cause), cause)
        else:
            start(cause)

    async def unmet(self, conditions: _Conditions) -> str:
        """Return the first of *conditions* that does not hold; empty if all do."""
        for text, condition in conditions:
            if not await self._holds(condition):
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

    async def _follow(self, trigger: Becomes, on_start: Callable[[object], None]) -> None:
        async for one in begun(self.node, trigger, self.store, is_new=True):
            on_start(one.cause)

    async def _check(self, conditions: _Conditions, start: Callable[[object], object], cause: object) -> None:
        if text := await self.unmet(conditions):
            self.record(f"held back: not {text!r}")
            self.log_limited(HELD_BACK, f"{self.title} did not run: {text!r} does not hold")
        else:
            start(cause)

    async def _holds(self, condition: Condition) -> bool:
        match condition:
            case SunIs():
                return self.sun_is_up() is condition.is_up
            case OnDays():
                return condition.days.has(self.now().date())
            case TimeSpan():
                return condition.has(self.now().time())
            case SunSpan():
                span = condition.on_day(self._sun_time)
                return span is not None and span.has(self.now().time())
            case LastRun():
                ago = self.clock.now() - self.store.get(_RAN_AT, -math.inf)
                return (ago > condition.seconds) is condition.is_over
            case Matches() if condition.state.lasting:
                devices = await self.devices.find()
                return holds_for(condition.state, devices, self.clock.now(), is_none=condition.is_none)
            case Matches():
                state = condition.state
                query = query_words(state.words) or query_terms(state.query)
                answer = await self._query.call(QueryDevicesRequest(query=query, limit=1))
                return bool(answer.results) is not condition.is_none
            case Press():
                return is_press(HouseView.of(self.node), condition, CURRENT_CAUSE.get())
            case AnyOf():
                for one in condition.conditions:
                    if await self._holds(one):
                        return True
                return False
            case _:
                assert_never(condition)

    def _sun_time(self, moment: SunMoment) -> time | None:
        """Return the time of *moment* today, or the nearest if it is on another day; None if there is none."""
        from homebot.apps.sun import sun_time  # noqa: PLC0415 - astral is for routines that ask

        home, today = self.context, self.now().date()
        at = sun_time(moment.event, home.latitude, home.longitude, moment.seconds).on(today, home.zone)
        if at is None:
            return None
        found = datetime.fromtimestamp(at, home.zone)
        return found.time() if found.date() == today else time.max if found.date() > today else time(microsecond=1)
