"""The base class of routines that were exported as apps: their steps are Python."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import AsyncIterator
from contextvars import ContextVar
from functools import partial
from typing import Any, ClassVar, Final

import anyio

from homebot.apps import NoSettings
from homebot.apps.run_modes import HandlerRuns, RunMode
from homebot.features.routines.base import RoutineBase
from homebot.features.routines.program import conditions_of
from homebot.features.routines.run import RoutineRun, RoutineRunFacts
from homebot.graph import Node
from homebot.support.isolation import error_text
from homebot.words.steps import in_turn, read_step

_STEP: Final = "_step"
"""The key of the step that a run takes."""

_RUN: ContextVar[RoutineRun] = ContextVar("homebot.routine_run")


class RoutineApp(RoutineBase[NoSettings]):
    """Calls :meth:`perform` whenever one of its triggers comes and its conditions hold.

    Unlike a routine, a run that waits when homebot stops is over.

    Attributes:
        when: Its triggers, each for itself, as in a routine.
        conditions: All of which must hold then.
        mode: The rule for a start while it runs; see :meth:`homebot.apps.App.on`.
    """

    when: ClassVar[tuple[str, ...]]
    conditions: ClassVar[tuple[str, ...]] = ()
    mode: ClassVar[RunMode] = "single"

    def __init__(self, node: Node, settings: NoSettings) -> None:
        super().__init__(node, settings)
        self._before: dict[str, list[Any]] = {}
        self._runs = HandlerRuns(node, self.start_task, "routine", self.mode)

    @abstractmethod
    async def perform(self) -> None:
        """Take the steps."""

    async def step(self, text: str) -> bool:
        """Take a step as a routine does, such as ``"hall lamp on, 20 %"``; a failure is logged.

        Returns:
            Whether the run goes on: a step may end with ``then stop``.

        Raises:
            UsageError: It is no step.
        """
        self.store[_STEP] = text
        run = _RUN.get()
        return await run.execute(read_step(in_turn(text, "step", run.turn) if run.turn else text))

    async def holds(self, *conditions: str) -> bool:
        """Return whether all *conditions* hold.

        Raises:
            UsageError: One is no condition.
        """
        run = _RUN.get()
        return not await self.unmet(conditions_of(conditions, run.turn), run.facts)

    async def turns(self, devices: str) -> AsyncIterator[None]:
        """Yield once for each device that the query *devices* finds, which is ``it`` in steps and conditions then."""
        run = _RUN.get()
        for device in await self.fitting(devices):
            run.facts = run.facts._replace(turns=(device,))
            yield
        run.facts = run.facts._replace(turns=())

    async def run(self) -> None:
        """Watch for its triggers, and tell of the run that a restart ended."""
        if step := self.store.pop(_STEP, ""):
            self.log_stop(repr(step), "homebot ended")
        self.watch(self.when, self._start)
        await anyio.sleep_forever()

    def _start(self, trigger: str, cause: object) -> None:
        perform = partial(self._perform, self.facts_of(trigger, cause))
        self.start_if(conditions_of(self.conditions), partial(self._runs.start, perform), cause, trigger)

    async def _perform(self, facts: RoutineRunFacts) -> None:
        self.begin_run()
        if self.mode != "restart":  # else the values from before the run that this one replaces
            self._before = {}
        _RUN.set(RoutineRun(self, before=self._before, facts=facts))
        try:
            await self.perform()
        except Exception as exc:
            if step := self.store.pop(_STEP, ""):
                self.log_stop(repr(step), error_text(exc))
            raise
        self._before = {}
        self.store.pop(_STEP, "")
