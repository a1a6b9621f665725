"""The tables ``[[routines]]``."""

from collections.abc import Iterator
from itertools import chain
from typing import Annotated

from pydantic import AfterValidator, ConfigDict, Field, model_validator

from homebot.apps import AppSettings
from homebot.apps.run_modes import RunMode
from homebot.config import value_errors
from homebot.features.routines.program import Branch, Conditions, StepSetting, Text, conditions_of, program_of
from homebot.support.folding import fold
from homebot.words.conditions import Condition, LastRun, StartedBy, SunIs, TimedOut, single_conditions
from homebot.words.message_values import Comparison, MessageValue
from homebot.words.steps import IT, MAX_LINES, MAX_ROUNDS, MAX_RUNS, Dim, Do, Notify, Undo, Wait, WaitFor, WaitUntil
from homebot.words.times import SunMoment, SunSpan
from homebot.words.triggers import Becomes, SunAngle, Trigger, read_trigger


def _trigger(text: str) -> str:
    with value_errors():
        read_trigger(text)
    return text


def _line(text: str) -> str:
    if len(text.splitlines()) != 1:
        raise ValueError("a name is one line")
    return text


def _values_in(asked: object) -> Iterator[MessageValue]:
    """Yield the values of the house in a condition or step, also those in calculations."""
    match asked:
        case Comparison():
            values = [asked.first, asked.second]
        case Do() | Notify() | Wait():
            values = [piece for piece in asked.pieces if isinstance(piece, MessageValue)]
        case _:
            return
    for value in values:
        yield from value.operands or (value,)


class RoutineSettings(AppSettings):
    """One routine.

    Attributes:
        name: Its name for people.
        when: Its triggers, each for itself; see :func:`homebot.words.triggers.read_trigger`.
        conditions: The key ``if``: its conditions, all of which must hold; see
            :func:`homebot.words.conditions.read_condition`.
        do: Its steps, one after the other; see :func:`homebot.words.steps.read_step`, or choices.
        mode: The rule for a start while it runs; see :meth:`homebot.apps.App.on`.
        max: The limit of running and waiting runs, with the modes ``queued`` and ``parallel``.
        enabled: Whether it may start.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, serialize_by_alias=True)

    name: Annotated[str, Field(min_length=1, max_length=100), AfterValidator(_line)]
    when: Annotated[tuple[Annotated[Text, AfterValidator(_trigger)], ...], Field(min_length=1, max_length=MAX_LINES)]
    conditions: Annotated[Conditions, Field(alias="if")] = ()
    do: Annotated[tuple[StepSetting, ...], Field(min_length=1, max_length=MAX_LINES)]
    mode: RunMode = "single"
    max: Annotated[int, Field(ge=1, le=MAX_ROUNDS)] = MAX_RUNS
    enabled: bool = True

    def asked(self) -> Iterator[tuple[str, Trigger | Condition]]:
        """Yield each trigger, condition, awaited state and held button, with its text."""
        yield from ((text, read_trigger(text)) for text in self.when)
        conditions = [*conditions_of(self.conditions)]
        for line in program_of(self.do):
            match line.step:
                case Branch():
                    conditions += line.step.conditions
                case WaitUntil() as wait:
                    yield from ((line.text, state) for state in wait.states)
                case WaitFor(triggers=triggers):
                    yield from ((line.text, trigger) for trigger in triggers)
                case Dim(held=held):
                    yield held.text, held
        yield from ((text, single) for text, condition in conditions for single in single_conditions(condition))

    def asking_the_sun(self) -> tuple[str, ...]:
        """Return its texts for which the place of the home must be known."""
        steps = [(line.text, line.step) for line in program_of(self.do)]
        return (
            *(text for text, asked in self.asked() if isinstance(asked, SunMoment | SunIs | SunSpan | SunAngle)),
            *(
                text
                for text, asked in (*self.asked(), *steps)
                if any(value.kind == "sun" for value in _values_in(asked))
            ),
        )

    def written(self) -> dict[str, object]:
        """Return its table as a person would write it: without default values."""
        return self.model_dump(exclude_defaults=True)

    @model_validator(mode="after")
    def _check_triggers_and_conditions(self) -> "RoutineSettings":
        triggers = [read_trigger(text) for text in self.when]
        if twice := [text for place, text in enumerate(self.when) if triggers[place] in triggers[:place]]:
            raise ValueError(f"when: {twice[0]!r} is there twice")
        started_by = [asked for _, asked in self.asked() if isinstance(asked, StartedBy) and not asked.of_wait]
        if other := next((condition.text for condition in started_by if condition.trigger not in triggers), ""):
            raise ValueError(f"if: started by {other!r} is none of the triggers in `when`")
        conditions = conditions_of(self.conditions)
        if early := next((text for text, condition in conditions if _is_of_wait(condition)), ""):
            raise ValueError(f"if: {early!r} is about a wait, and none comes before")
        return self

    @model_validator(mode="after")
    def _check_steps(self) -> "RoutineSettings":
        lines = program_of(self.do)
        steps = [line.step for line in lines]
        if steps[0] == Undo():
            raise ValueError("do: the first step is `undo`, and there is nothing to undo yet")
        if alone := next((text for text, step in lines if isinstance(step, Do | Dim) and step.target == IT), ""):
            raise ValueError(f"do: {alone!r}: `it` is the device in turn of a for_each; write which device is meant")
        conditions = chain.from_iterable(step.conditions for step in steps if isinstance(step, Branch))
        if inner := next((text for text, asked in conditions if LastRun in map(type, single_conditions(asked))), ""):
            raise ValueError(f"do: {inner!r} is about the run before, which only the conditions of the routine know")
        waited = [trigger for step in steps if isinstance(step, WaitFor) for trigger in step.triggers]
        ends = [asked for _, asked in self.asked() if isinstance(asked, StartedBy) and asked.of_wait]
        if other := next((end.text for end in ends if end.trigger not in waited), ""):
            raise ValueError(f"do: wait ended by {other!r} is none of the triggers of a `wait for`")
        states = {fold(trigger.text) for trigger in map(read_trigger, self.when) if isinstance(trigger, Becomes)}
        for text, step in lines:
            if isinstance(step, Do) and fold(f"{step.target} {step.command}") in states:
                raise ValueError(f"do: {text!r} brings about what starts it, so it would start itself")
        return self


def _is_of_wait(condition: Condition) -> bool:
    return isinstance(condition, TimedOut) or (isinstance(condition, StartedBy) and condition.of_wait)
