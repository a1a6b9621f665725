"""The steps of a routine in the order in which they run: choices and loops are jumps. Pure."""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Annotated, Final, NamedTuple, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field, PlainSerializer, PlainValidator, model_validator

from homebot.config import parse_settings, value_errors
from homebot.errors import ConfigError, UsageError
from homebot.words.conditions import Condition, check_possible, read_condition
from homebot.words.own_language import BlockKind, block_in_language, devices_to_english, in_language, read_block
from homebot.words.queries import parse_query
from homebot.words.steps import MAX_LINES, MAX_ROUNDS, Step, Wait, WaitFor, WaitUntil, in_turn, read_step
from homebot.words.tokens import split_at

_MAX_CHARACTERS = 300
_MAX_PROGRAM: Final = 1000
"""Steps of a loop, those of all rounds that have a number."""

Text = Annotated[str, Field(min_length=1, max_length=_MAX_CHARACTERS)]


def _condition(text: str) -> str:
    with value_errors():
        read_condition(text)
    return text


def _possible(texts: tuple[str, ...]) -> tuple[str, ...]:
    with value_errors():
        check_possible(texts)
    return texts


def _step(text: str) -> str:
    with value_errors():
        read_step(text)
    return text


def _devices(text: str) -> str:
    with value_errors():
        parse_query(devices_to_english(text))
    return text


Conditions = Annotated[
    tuple[Annotated[Text, AfterValidator(_condition)], ...], Field(max_length=MAX_LINES), AfterValidator(_possible)
]
"""Conditions that hold together at times."""


class Choice(BaseModel):
    """A step that chooses between others.

    Attributes:
        conditions: The key ``if``: the conditions for *do*, all of which must hold.
        do: The steps if they hold.
        otherwise: The key ``else``: the steps if they do not hold.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, serialize_by_alias=True)

    conditions: Annotated[Conditions, Field(alias="if", min_length=1)]
    do: Annotated[tuple["StepSetting", ...], Field(min_length=1, max_length=MAX_LINES)]
    otherwise: Annotated[tuple["StepSetting", ...], Field(alias="else", max_length=MAX_LINES)] = ()

    def __str__(self) -> str:
        return step_text(self)


class RepeatedSteps(BaseModel):
    """Steps that are repeated: a number of times, while conditions hold, or until they do after a round.

    Attributes:
        times: The key ``repeat``: how often.
        as_long_as: The key ``while``: the conditions for each round, all of which must hold.
        until: The conditions after which no round follows, all of which must hold.
        do: The steps of a round. Without a number of rounds one of them waits, so that the house is not flooded.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, serialize_by_alias=True)

    times: Annotated[int, Field(alias="repeat", ge=0, le=MAX_ROUNDS)] = 0
    as_long_as: Annotated[Conditions, Field(alias="while")] = ()
    until: Conditions = ()
    do: Annotated[tuple["StepSetting", ...], Field(min_length=1, max_length=MAX_LINES)]

    def __str__(self) -> str:
        return step_text(self)

    @model_validator(mode="after")
    def _check_together(self) -> "RepeatedSteps":
        if bool(self.times) + bool(self.as_long_as) + bool(self.until) != 1:
            raise ValueError("a loop has one of the keys repeat, while and until")
        lines = program_of(self.do)
        if not self.times and not any(isinstance(line.step, Wait | WaitFor | WaitUntil) for line in lines):
            raise ValueError("do: a loop with while or until has a step that waits, such as 'wait 1m'")
        if len(lines) * max(self.times, 1) > _MAX_PROGRAM:
            raise ValueError(f"do: all rounds together have more than {_MAX_PROGRAM:,} steps")
        return self


class StepsForEach(BaseModel):
    """Steps that are taken once for each device that fits when they begin, in the order of their names.

    Attributes:
        devices: The key ``for_each``: a query.
        do: The steps, in which ``it`` is the device in turn.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", defer_build=True, serialize_by_alias=True)

    devices: Annotated[Text, Field(alias="for_each"), AfterValidator(_devices)]
    do: Annotated[tuple["StepSetting", ...], Field(min_length=1, max_length=MAX_LINES)]

    def __str__(self) -> str:
        return step_text(self)

    @model_validator(mode="after")
    def _check_together(self) -> "StepsForEach":
        with value_errors():
            lines = program_of((self,))
        if sum(isinstance(line.step, ForEach) for line in lines) > 1:
            raise ValueError("do: another for_each is in this one; write it as a step after it")
        return self


Block: TypeAlias = Choice | RepeatedSteps | StepsForEach


def step_text(step: str | Block, language: str = "") -> str:
    """Return *step* for people, as *language* says it if that is given; a choice or loop is a sentence."""
    if isinstance(step, str):
        return in_language(step, "step", language) if language else step

    def of(texts: Iterable[str]) -> list[str]:
        return [in_language(text, "condition", language) if language else text for text in texts]

    do = [step_text(one, language) for one in step.do]
    match step:
        case Choice():
            otherwise = [step_text(one, language) for one in step.otherwise]
            kind: BlockKind = "if else" if otherwise else "if"
            return block_in_language(kind, language, do, conditions=of(step.conditions), otherwise=otherwise)
        case StepsForEach():
            return block_in_language("for each", language, do, devices=step.devices)
    kind = "times" if step.times else "while" if step.as_long_as else "until"
    conditions = of(step.as_long_as or step.until)
    return block_in_language(kind, language, do, conditions=conditions, times=step.times)


def _step_or_block(value: object) -> str | Block:
    """Check a step here, because the errors of a union would name all of its members."""
    if isinstance(value, str) and len(value) <= _MAX_CHARACTERS:
        value = _block_of(value) or value
    if isinstance(value, dict):
        try:
            if "if" in value:
                return parse_settings(Choice, value, "", "")
            if "for_each" in value:
                return parse_settings(StepsForEach, value, "", "")
            return parse_settings(RepeatedSteps, value, "", "")
        except ConfigError as exc:
            raise ValueError(f"{exc.key}: {exc.reason}".removeprefix(": ")) from exc
    if isinstance(value, str) and 0 < len(value) <= _MAX_CHARACTERS:
        return _step(value)
    raise ValueError(
        f"must be a text of at most {_MAX_CHARACTERS} characters, a choice {{ if = [...], do = [...] }}, "
        "or a loop { repeat = 3, do = [...] } or { for_each = 'open window', do = [...] }"
    )


def _block_of(text: str) -> dict[str, object] | None:
    """Return the table of a choice or loop that is written as a sentence, as :func:`step_text` does; None for none."""
    if (found := read_block(text)) is None:
        return None
    kind, value, word, do, otherwise = found
    if kind == "times":
        return {"repeat": int(value), "do": do}
    if kind == "for each":
        return {"for_each": value, "do": do}
    conditions, open_part = list[str](), ""
    for part in split_at(value, word):
        open_part = f"{open_part} {word} {part}" if open_part else part  # `between 22:00 and 6:30` is one
        with suppress(UsageError):
            read_condition(open_part)
            conditions.append(open_part)
            open_part = ""
    conditions += [open_part] if open_part else []
    table: dict[str, object] = {kind: conditions, "do": do}
    return table | ({"else": otherwise} if otherwise else {})


def _written(step: str | Block) -> object:
    return step if isinstance(step, str) else step.model_dump(exclude_defaults=True)


StepSetting = Annotated[str | Block, PlainValidator(_step_or_block), PlainSerializer(_written)]


@dataclass(frozen=True, slots=True)
class Branch:
    """Goes on with the next line if all of its conditions hold, else after *over* more lines."""

    conditions: tuple[tuple[str, Condition], ...]
    over: int


@dataclass(frozen=True, slots=True)
class Skip:
    """Goes on after *over* more lines."""

    over: int


@dataclass(frozen=True, slots=True)
class Back:
    """Goes on with the line that is *over* lines before this one."""

    over: int


@dataclass(frozen=True, slots=True)
class ForEach:
    """Goes on with the first of the devices that fit in turn, or after *over* more lines if there is none."""

    devices: str
    over: int


@dataclass(frozen=True, slots=True)
class NextTurn:
    """Goes on with the line that is *over* lines before this one if another device follows."""

    over: int


Instruction: TypeAlias = Step | Branch | Skip | Back | ForEach | NextTurn


class Line(NamedTuple):
    """A line of a program, with its text for people."""

    text: str
    step: Instruction


def program_of(steps: Sequence[str | Block]) -> tuple[Line, ...]:
    """Return the program of *steps*, which are checked.

    In the steps of a ``for_each``, ``it`` is read as all of its devices; their texts have it still.
    """
    return tuple(_lines(steps))


def conditions_of(texts: Iterable[str], turn: str = "") -> tuple[tuple[str, Condition], ...]:
    """Return conditions with their texts; ``it`` is *turn*, a query, if that is given."""
    return tuple((text, read_condition(in_turn(text, "condition", turn) if turn else text)) for text in texts)


def _lines(steps: Iterable[str | Block], turn: str = "") -> Iterator[Line]:
    for one in steps:
        if isinstance(one, str):
            yield Line(one, read_step(in_turn(one, "step", turn) if turn else one))
            continue
        text = str(one)
        if isinstance(one, StepsForEach):
            devices = devices_to_english(one.devices)
            do = tuple(_lines(one.do, f"({devices})"))
            yield Line(text, ForEach(devices, len(do) + 1))
            yield from do
            yield Line(text, NextTurn(len(do)))
            continue
        do = tuple(_lines(one.do, turn))
        if isinstance(one, Choice):
            otherwise = tuple(_lines(one.otherwise, turn))
            yield Line(text, Branch(conditions_of(one.conditions, turn), len(do) + bool(otherwise)))
            yield from do
            if otherwise:
                yield Line(text, Skip(len(otherwise)))
                yield from otherwise
        elif one.as_long_as:
            yield Line(text, Branch(conditions_of(one.as_long_as, turn), len(do) + 1))
            yield from do
            yield Line(text, Back(len(do) + 1))
        elif one.until:
            yield from do
            yield Line(text, Branch(conditions_of(one.until, turn), 1))
            yield Line(text, Skip(1))
            yield Line(text, Back(len(do) + 2))
        else:
            yield from do * one.times
