"""The steps of a routine in the order in which they run: a choice is a jump over those that are not taken. Pure."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated, NamedTuple, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainSerializer, PlainValidator

from homebot.config import parse_settings, value_errors
from homebot.errors import ConfigError
from homebot.words.conditions import Condition, read_condition
from homebot.words.steps import MAX_LINES, Step, read_step

_MAX_CHARACTERS = 300

Text = Annotated[str, Field(min_length=1, max_length=_MAX_CHARACTERS)]


def _condition(text: str) -> str:
    with value_errors():
        read_condition(text)
    return text


def _step(text: str) -> str:
    with value_errors():
        read_step(text)
    return text


ConditionText = Annotated[Text, AfterValidator(_condition)]
_StepText = Annotated[Text, AfterValidator(_step)]


class Choice(BaseModel):
    """A step that chooses between others.

    Attributes:
        conditions: The key ``if``: the conditions for *do*, all of which must hold.
        do: The steps if they hold, which are no choices.
        otherwise: The key ``else``: the steps if they do not hold, among which further choices may be.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, serialize_by_alias=True)

    conditions: Annotated[tuple[ConditionText, ...], Field(alias="if", min_length=1, max_length=MAX_LINES)]
    do: Annotated[tuple[_StepText, ...], Field(min_length=1, max_length=MAX_LINES)]
    otherwise: Annotated[tuple["StepSetting", ...], Field(alias="else", max_length=MAX_LINES)] = ()

    def __str__(self) -> str:
        otherwise = f", else: {'; '.join(map(str, self.otherwise))}" if self.otherwise else ""
        return f"if {' and '.join(self.conditions)}: {'; '.join(self.do)}{otherwise}"


def _step_or_choice(value: object) -> str | Choice:
    """Check a step here, because the errors of a union would name all of its members."""
    if isinstance(value, dict):
        try:
            return parse_settings(Choice, value, "", "")
        except ConfigError as exc:
            raise ValueError(f"{exc.key}: {exc.reason}") from exc
    if isinstance(value, str) and 0 < len(value) <= _MAX_CHARACTERS:
        return _step(value)
    raise ValueError(
        f"must be a text of at most {_MAX_CHARACTERS} characters, or a choice {{ if = [...], do = [...] }}"
    )


def _written(step: str | Choice) -> object:
    return step if isinstance(step, str) else step.model_dump(exclude_defaults=True)


StepSetting = Annotated[str | Choice, PlainValidator(_step_or_choice), PlainSerializer(_written)]


@dataclass(frozen=True, slots=True)
class Branch:
    """Goes on with the next line if all of its conditions hold, else after *over* more lines."""

    conditions: tuple[tuple[str, Condition], ...]
    over: int


@dataclass(frozen=True, slots=True)
class Skip:
    """Goes on after *over* more lines."""

    over: int


Instruction: TypeAlias = Step | Branch | Skip


class Line(NamedTuple):
    """A line of a program, with its text for people."""

    text: str
    step: Instruction


def program_of(steps: Sequence[str | Choice]) -> tuple[Line, ...]:
    """Return the program of *steps*, which are checked."""
    return tuple(_lines(steps))


def conditions_of(texts: Iterable[str]) -> tuple[tuple[str, Condition], ...]:
    """Return conditions with their texts."""
    return tuple((text, read_condition(text)) for text in texts)


def _lines(steps: Iterable[str | Choice]) -> Iterator[Line]:
    for one in steps:
        if isinstance(one, str):
            yield Line(one, read_step(one))
            continue
        otherwise = program_of(one.otherwise)
        yield Line(str(one), Branch(conditions_of(one.conditions), len(one.do) + bool(otherwise)))
        yield from _lines(one.do)
        if otherwise:
            yield Line(str(one), Skip(len(otherwise)))
            yield from otherwise
