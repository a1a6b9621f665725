"""The app that one routine is."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any, Final, assert_never, final

import anyio

from homebot.apps import App
from homebot.apps.run_modes import HandlerRuns
from homebot.devices.app_messages import RoutineChange, RoutineInfo, RoutineNote
from homebot.devices.command_messages import CommandDevices
from homebot.devices.house_view import HouseView
from homebot.devices.names import COMMAND_DEVICES, QUERY_DEVICES
from homebot.devices.query.term_messages import query_terms
from homebot.devices.services import QueryDevices, QueryDevicesRequest
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.messages import Time
from homebot.routines.conditions import Condition, Matches, OnDays, SunIs
from homebot.routines.program import conditions_of, program_of
from homebot.routines.run import RoutineRun
from homebot.routines.settings import RoutineSettings
from homebot.routines.text import routine_text
from homebot.routines.times import DaysAndTime, SunMoment, TimeSpan
from homebot.routines.triggers import Becomes, PersonMoves, Press, RobotArrival, read_trigger
from homebot.routines.watches import ArrivalWatch, PersonWatch, PressWatch, begun, is_press

__all__ = ["Routine"]

DONE: Final = "routine.step_done"
HELD_BACK: Final = "routine.held_back"
FAILED: Final = "routine.step_failed"

_MOST_RUNS_KEPT: Final = 10


@final
class Routine(App[RoutineSettings]):
    """Performs the steps of a routine whenever one of its triggers comes and its conditions hold.

    A run survives a restart of homebot if it was in a wait: it goes on where it was, and its commands have no trigger.
    """

    def __init__(self, node: Node, settings: RoutineSettings) -> None:
        super().__init__(node, settings)
        self._conditions = conditions_of(settings.conditions)
        self._program = program_of(settings.do)
        self._steps = tuple(map(str, settings.do))
        self.commands = node.create_client(CommandDevices, COMMAND_DEVICES)
        self._query = node.create_client(QueryDevices, QUERY_DEVICES)
        self._before: dict[str, list[Any]] = {}
        self._runs = HandlerRuns(node, self.start_task, f"routine {settings.name}", settings.mode)

    async def run(self) -> None:
        """Watch for its triggers, and go on with the run that a restart interrupted."""
        since = self.clock.now()
        for text in self.settings.when:
            trigger = read_trigger(text)
            match trigger:
                case DaysAndTime():
                    self.daily(trigger.time, self._on_time, days=trigger.days, name=text)
                case SunMoment():
                    self.at(trigger.event, self._on_time, offset=trigger.offset, name=text)
                case Becomes():
                    self.start_task(partial(self._follow, trigger, since))
                case Press():
                    PressWatch(self.node, trigger, self._start)
                case PersonMoves():
                    PersonWatch(self.node, trigger, self._start)
                case RobotArrival():
                    ArrivalWatch(self.node, trigger, self._start)
                case _:
                    assert_never(trigger)
        kept: dict[str, Any] | None = self.store.get("run")
        if kept is not None and kept.get("steps") == [*self._steps]:  # else its place is that of another step now
            self._runs.start(partial(self._perform, kept["place"], kept["until"], dict(kept["before"])))
        await anyio.sleep_forever()  # an app ends with its tasks, and presses and arrivals need none

    @property
    def is_enabled(self) -> bool:
        """True if it may start: as configured, or as it was switched last."""
        return bool(self.store.get("enabled", self.settings.enabled))

    def info(self) -> RoutineInfo:
        """Return the facts for clients about it."""
        due = [at.timestamp() for job in self.jobs if (at := job.next) is not None]
        notes = (RoutineNote(at=Time.from_seconds(at), text=text) for at, text in self.store.get("runs", ()))
        return RoutineInfo(
            name=self.settings.name,
            app=self.node.name,
            when=self.settings.when,
            conditions=self.settings.conditions,
            steps=self._steps,
            mode=self.settings.mode,
            enabled=self.is_enabled,
            is_running=self._runs.running_since is not None,
            next=Time.from_seconds(min(due, default=0.0)),
            notes=tuple(notes),
            text=routine_text(self.settings.written()),
        )

    def change(self, change: RoutineChange) -> str:
        """Start it now, without its conditions, or switch it on or off; return a text for people."""
        name = self.settings.name
        if change == "run":
            is_started = self._runs.start(self._perform, CURRENT_CAUSE.get())
            return f"started {name}" if is_started else f"{name} runs already, or is not called any more"
        self.store["enabled"] = change == "enable"
        if change == "disable":
            self._runs.cancel()
            self.store.pop("run", None)
        return f"{change}d {name}"

    def keep(self, place: int, until: float, before: dict[str, list[Any]]) -> None:
        """Store how far the run is, for a restart."""
        self.store["run"] = {"place": place, "until": until, "before": before, "steps": self._steps}

    def log_done(self, step: str) -> None:
        """Log that a step that no device's journal knows was done."""
        self._record(f"done: {step!r}")
        self.log_limited(DONE, f"{self.settings.name}: {step!r} is done")

    def log_failure(self, step: str, problem: str) -> None:
        """Log that a step failed; the next ones follow all the same."""
        self._record(f"{step!r} failed: {problem}")
        self.log_limited(FAILED, f"{self.settings.name}: {step!r} failed: {problem}")

    def _on_time(self) -> None:
        self._start(CURRENT_CAUSE.get())

    async def _follow(self, trigger: Becomes, since: float) -> None:
        async for one in begun(self.node, trigger, since):
            self._start(one.cause)

    def _start(self, cause: object) -> None:
        if self.is_enabled:
            self._runs.start(self._run_if, cause)

    async def _run_if(self) -> None:
        if text := await self.unmet(self._conditions):
            self._record(f"held back: not {text!r}")
            self.log_limited(HELD_BACK, f"{self.settings.name} did not run: {text!r} does not hold")
        else:
            await self._perform()

    async def unmet(self, conditions: Sequence[tuple[str, Condition]]) -> str:
        """Return the first of *conditions* that does not hold; empty if all do."""
        for text, condition in conditions:
            if not await self._holds(condition):
                return text
        return ""

    async def _perform(self, first: int = 0, until: float = 0.0, before: dict[str, list[Any]] | None = None) -> None:
        self._record("ran" if not first else f"went on at {self._program[first].text!r}")
        if before is None and self.settings.mode == "restart":
            before = self._before  # to bring back the values from before the run that this one replaces
        self._before = {} if before is None else before
        await RoutineRun(self, self._program, self._before).perform(first, until)
        self.store.pop("run", None)

    async def _holds(self, condition: Condition) -> bool:
        match condition:
            case SunIs():
                return self.sun_is_up() is condition.is_up
            case OnDays():
                return self.now().weekday() in condition.days
            case TimeSpan():
                return condition.contains(self.now())
            case Matches():
                query = QueryDevicesRequest(query=query_terms(condition.state.query))
                answer = await self._query.call(query)
                return bool(answer.results) is not condition.is_none
            case Press():
                return is_press(HouseView.of(self.node), condition, CURRENT_CAUSE.get())
            case _:
                assert_never(condition)

    def _record(self, text: str) -> None:
        """Add a line to the last runs in the store."""
        runs = [*self.store.get("runs", []), [self.clock.now(), text]]
        self.store["runs"] = runs[-_MOST_RUNS_KEPT:]
