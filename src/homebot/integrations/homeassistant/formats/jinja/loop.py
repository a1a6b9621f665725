"""The loop ``for`` of a template. Pure."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

from homebot.integrations.homeassistant.formats.jinja.evaluation import Evaluate, Run
from homebot.integrations.homeassistant.formats.jinja.lists import values_of
from homebot.integrations.homeassistant.formats.jinja.values import UNDEFINED

Assign: TypeAlias = Callable[[Run, object], None]
"""Assigns a value to its target."""


class BreakLoop(Exception):
    """Ends the innermost loop."""


class ContinueLoop(Exception):
    """Ends a turn of the innermost loop."""


@dataclass(frozen=True, slots=True)
class Loop:
    """A compiled loop.

    Attributes:
        test: Its filter; None for none.
        weight: Nodes of one turn.
    """

    values: Evaluate
    target: Assign
    test: Evaluate | None
    body: Evaluate
    otherwise: Evaluate
    weight: int

    def execute(self, run: Run) -> None:
        """Run the loop."""
        values = values_of(run, self.values(run))
        if self.test is None:
            chosen = values
        else:
            chosen = []
            for value in values:
                run.spend(self.weight)
                with run.scope():
                    self.target(run, value)
                    if self.test(run):
                        chosen.append(value)
        for index, value in enumerate(chosen):
            run.spend(self.weight)
            with run.scope():
                run.assign("loop", _position(chosen, index))
                self.target(run, value)
                try:
                    self.body(run)
                except ContinueLoop:
                    continue
                except BreakLoop:
                    break
        if not chosen:
            self.otherwise(run)


def _position(values: list[object], index: int) -> dict[str, object]:
    count = len(values)
    return {
        "index": index + 1,
        "index0": index,
        "revindex": count - index,
        "revindex0": count - index - 1,
        "first": index == 0,
        "last": index == count - 1,
        "length": count,
        "previtem": values[index - 1] if index else UNDEFINED,
        "nextitem": values[index + 1] if index < count - 1 else UNDEFINED,
    }
