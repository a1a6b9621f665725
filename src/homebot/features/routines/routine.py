"""The app that one routine is."""

from __future__ import annotations

from functools import partial
from itertools import accumulate
from typing import Any, Final, final

import anyio

from homebot.apps.run_modes import HandlerRuns
from homebot.devices.app_messages import RoutineChange, RoutineInfo, RoutineNote
from homebot.features.routines.base import RoutineBase
from homebot.features.routines.program import conditions_of, program_of
from homebot.features.routines.run import RoutineRun, RoutineRunFacts, RunPlace
from homebot.features.routines.settings import RoutineSettings
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.messages import Time
from homebot.support.isolation import error_text
from homebot.words.routine_text import routine_text

_MAX_RUNS_KEPT: Final = 10
_KEPT: Final = "waiting"
"""The runs, in the store, each with the step that it takes."""


@final
class Routine(RoutineBase[RoutineSettings]):
    """Performs the steps of a routine whenever one of its triggers comes and its conditions hold.

    After a restart of homebot a run goes on in its wait, or with a command that may be given twice, without a trigger.
    In any other step, such as a press or a drive, whether that was done is unknown, and the run is over.
    """

    def __init__(self, node: Node, settings: RoutineSettings) -> None:
        super().__init__(node, settings)
        self.title = settings.name
        self._conditions = conditions_of(settings.conditions)
        self._program = program_of(settings.do)
        self._steps = tuple(map(str, settings.do))
        self._before: dict[str, list[Any]] = {}
        self._runs = HandlerRuns(node, self.start_task, f"routine {settings.name}", settings.mode, settings.max)

    async def run(self) -> None:
        """Watch for its triggers, and go on with the run that a restart interrupted."""
        self.watch(self.settings.when, self._start)
        kept, self.store[_KEPT] = self.store.get(_KEPT, {}), {}
        for one in kept.values():
            if one["steps"] != [*self._steps]:
                self.log_stop(one.get("step", "a wait"), "its steps were changed")
            elif not one.get("may_repeat", True):  # homebot 0.1 kept only waits
                self.log_stop(one["step"], "homebot ended, and whether it was done is unknown, so it is not done again")
            else:
                turns = tuple(one.get("turns", ()))
                known = {key: one[key] for key in RoutineRunFacts._fields if key in one}
                facts = RoutineRunFacts(**known | {"turns": turns})
                self._runs.start(partial(self._perform, facts, one["place"], one["until"], dict(one["before"])))
        await anyio.sleep_forever()  # an app ends with its tasks, and presses and arrivals need none

    @property
    def is_enabled(self) -> bool:
        """True if it may start: as configured, or as it was switched last."""
        return bool(self.store.get("enabled", self.settings.enabled))

    def info(self) -> RoutineInfo:
        """Return the facts for clients about it."""
        due = [at.timestamp() for job in self.jobs if self.is_enabled and (at := job.next) is not None]
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
            is_started = self._runs.start(partial(self._perform, RoutineRunFacts()), CURRENT_CAUSE.get())
            return f"started {name}" if is_started else f"{name} runs already, or is not called any more"
        self.store["enabled"] = change == "enable"
        if change == "disable":
            self._runs.cancel()
            for one in self.store.get(_KEPT, {}).values():
                self.log_stop(one["step"], "the routine was disabled")
            self.store[_KEPT] = {}
        return f"{change}d {name}"

    async def keep(self, run: RoutineRun, place: RunPlace, before: dict[str, list[Any]]) -> None:
        """Store how far *run* is, for a restart; at once before a step that must not be done twice."""
        ends = accumulate(len(program_of((one,))) for one in self.settings.do)
        number = next(number for number, end in enumerate(ends, 1) if place.line < end)
        kept = {"place": place.line, "until": place.until, "may_repeat": place.may_repeat, "before": before}
        kept |= run.facts._asdict()
        kept |= {"steps": self._steps, "step": f"step {number}, {self._program[place.line].text!r}"}
        known = self.store.get(_KEPT, {})
        self.store[_KEPT] = {**known, str(id(run)): kept}
        if not place.may_repeat:
            await self.context.write_stores()
        elif not known.get(str(id(run)), {}).get("may_repeat"):
            self.start_task(self.context.write_stores)  # after a sudden death the run is known, with its place

    def _start(self, trigger: str, cause: object) -> None:
        if self.is_enabled:
            perform = partial(self._perform, self.facts_of(trigger, cause))
            self.start_if(self._conditions, partial(self._runs.start, perform), cause, trigger)

    async def _perform(
        self, facts: RoutineRunFacts, first: int = 0, until: float = 0.0, before: dict[str, list[Any]] | None = None
    ) -> None:
        self.record("ran" if before is None else f"went on at {self._program[first].text!r}")
        if before is None:
            self.begin_run()
        if before is None and self.settings.mode == "restart":
            before = self._before  # to bring back the values from before the run that this one replaces
            self.store[_KEPT] = {}
        self._before = {} if before is None else before
        run = RoutineRun(self, self._program, self._before, facts)
        try:
            await run.perform(first, until)
        except Exception as exc:
            self._forget(run, error_text(exc))
            raise
        self._forget(run)

    def _forget(self, run: RoutineRun, problem: str = "") -> None:
        others = dict(self.store.get(_KEPT, {}))
        kept = others.pop(str(id(run)), None)
        self.store[_KEPT] = others
        if problem and kept is not None:
            self.log_stop(kept["step"], problem)

    def record(self, text: str) -> None:
        """Add a line to the last runs in the store."""
        runs = [*self.store.get("runs", []), [self.clock.now(), text]]
        self.store["runs"] = runs[-_MAX_RUNS_KEPT:]
