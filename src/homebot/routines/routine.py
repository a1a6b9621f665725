"""The app that one routine is."""

from __future__ import annotations

from functools import partial
from typing import Any, Final, final

import anyio

from homebot.apps.run_modes import HandlerRuns
from homebot.devices.app_messages import RoutineChange, RoutineInfo, RoutineNote
from homebot.graph import Node
from homebot.graph.current_cause import CURRENT_CAUSE
from homebot.messages import Time
from homebot.routines.base import RoutineBase
from homebot.routines.program import conditions_of, program_of
from homebot.routines.run import RoutineRun
from homebot.routines.settings import RoutineSettings
from homebot.routines.text import routine_text

__all__ = ["Routine"]

_MOST_RUNS_KEPT: Final = 10
_KEPT: Final = "waiting"
"""The runs in a wait, in the store."""


@final
class Routine(RoutineBase[RoutineSettings]):
    """Performs the steps of a routine whenever one of its triggers comes and its conditions hold.

    A run survives a restart of homebot if it was in a wait: it goes on where it was, and its commands have no trigger.
    """

    def __init__(self, node: Node, settings: RoutineSettings) -> None:
        super().__init__(node, settings)
        self.title = settings.name
        self._conditions = conditions_of(settings.conditions)
        self._program = program_of(settings.do)
        self._steps = tuple(map(str, settings.do))
        self._before: dict[str, list[Any]] = {}
        self._runs = HandlerRuns(node, self.start_task, f"routine {settings.name}", settings.mode)

    async def run(self) -> None:
        """Watch for its triggers, and go on with the run that a restart interrupted."""
        self.watch(self.settings.when, self._start)
        kept, self.store[_KEPT] = self.store.get(_KEPT, {}), {}
        for one in kept.values():
            if one["steps"] == [*self._steps]:  # else its place is that of another step now
                self._runs.start(partial(self._perform, one["place"], one["until"], dict(one["before"])))
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
            self.store[_KEPT] = {}
        return f"{change}d {name}"

    def keep(self, run: RoutineRun, place: int, until: float, before: dict[str, list[Any]]) -> None:
        """Store how far *run* is, for a restart."""
        kept = {"place": place, "until": until, "before": before, "steps": self._steps}
        self.store[_KEPT] = {**self.store.get(_KEPT, {}), str(id(run)): kept}

    def _start(self, cause: object) -> None:
        if self.is_enabled:
            self.start_if(self._conditions, partial(self._runs.start, self._perform), cause)

    async def _perform(self, first: int = 0, until: float = 0.0, before: dict[str, list[Any]] | None = None) -> None:
        self.record("ran" if not first else f"went on at {self._program[first].text!r}")
        if before is None and self.settings.mode == "restart":
            before = self._before  # to bring back the values from before the run that this one replaces
            self.store[_KEPT] = {}
        self._before = {} if before is None else before
        run = RoutineRun(self, self._program, self._before)
        await run.perform(first, until)
        self.store[_KEPT] = {key: one for key, one in self.store.get(_KEPT, {}).items() if key != str(id(run))}

    def record(self, text: str) -> None:
        """Add a line to the last runs in the store."""
        runs = [*self.store.get("runs", []), [self.clock.now(), text]]
        self.store["runs"] = runs[-_MOST_RUNS_KEPT:]
