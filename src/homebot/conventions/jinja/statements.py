"""Statements of a template, each made to write or to assign in a run, and the program that they are."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from datetime import datetime
from typing import TypeAlias, final

from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.expressions import Evaluate
from homebot.conventions.jinja.limits import TemplateError
from homebot.conventions.jinja.lists import values_of
from homebot.conventions.jinja.values import UNDEFINED, Namespace

__all__ = [
    "Assign",
    "Execute",
    "Program",
    "assignment",
    "block_assignment",
    "break_loop",
    "choice",
    "continue_loop",
    "loop",
    "output",
    "to_attribute",
    "to_name",
    "to_several",
]


Execute: TypeAlias = Callable[[Run], None]
Assign: TypeAlias = Callable[[Run, object], None]


def output(values: Sequence[Evaluate]) -> Execute:
    """Write values, texts between them included."""

    def execute(run: Run) -> None:
        for value in values:
            run.write(value(run))

    return execute


def choice(cases: Sequence[tuple[Evaluate, Sequence[Execute]]], otherwise: Sequence[Execute]) -> Execute:
    """Execute ``if``, with every ``elif`` as a further case."""

    def execute(run: Run) -> None:
        for test, body in cases:
            if test(run):
                chosen = body
                break
        else:
            chosen = otherwise
        for statement in chosen:
            statement(run)

    return execute


def assignment(target: Assign, value: Evaluate) -> Execute:
    """Execute ``set`` with a value."""
    return lambda run: target(run, value(run))


def block_assignment(target: Assign, body: Sequence[Execute]) -> Execute:
    """Execute ``set`` with the output of a block."""

    def execute(run: Run) -> None:
        start = run.mark()
        run.enter()
        for statement in body:
            statement(run)
        run.leave()
        target(run, run.written(start))

    return execute


def to_name(name: str) -> Assign:
    """Assign to a name."""
    return lambda run, value: run.assign(name, value)


def to_attribute(name: str, attribute: str) -> Assign:
    """Assign to an attribute of a namespace."""

    def assign(run: Run, value: object) -> None:
        owner = run.lookup(name)
        if not isinstance(owner, Namespace):
            raise TemplateError("only a namespace has attributes that can be set")
        owner.attributes[attribute] = value

    return assign


def to_several(targets: Sequence[Assign]) -> Assign:
    """Assign the items of a value, one to each target."""

    def assign(run: Run, value: object) -> None:
        values = values_of(run, value)
        for target, one in zip(targets, values, strict=True):
            target(run, one)

    return assign


def loop(
    target: Assign,
    values: Evaluate,
    test: Evaluate | None,
    body: Sequence[Execute],
    otherwise: Sequence[Execute],
    weight: int,
) -> Execute:
    """Execute ``for``, with ``loop`` as a mapping.

    Args:
        target: The target of each value, in a scope of its own.
        values: The values of the loop.
        test: Which of them count; None for all.
        body: The work for each value.
        otherwise: The work if there is none.
        weight: Work of one turn, in steps.
    """

    def execute(run: Run) -> None:
        kept = _kept(run, values_of(run, values(run)), target, test, weight)
        for index in range(len(kept)):
            run.spend(weight)
            run.enter()
            run.assign("loop", _position(kept, index))
            target(run, kept[index])
            try:
                for statement in body:
                    statement(run)
            except _ContinueLoop:
                continue
            except _BreakLoop:
                break
            finally:
                run.leave()
        if not kept:
            for statement in otherwise:
                statement(run)

    return execute


def break_loop(_: Run) -> None:
    """Execute ``break``."""
    raise _BreakLoop


def continue_loop(_: Run) -> None:
    """Execute ``continue``."""
    raise _ContinueLoop


class _BreakLoop(Exception):
    """Ends the innermost loop."""


class _ContinueLoop(Exception):
    """Ends a turn of the innermost loop."""


def _kept(run: Run, values: list[object], target: Assign, test: Evaluate | None, weight: int) -> list[object]:
    if test is None:
        return values
    kept = []
    for value in values:
        run.spend(weight)
        run.enter()
        target(run, value)
        if test(run):
            kept.append(value)
        run.leave()
    return kept


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


@final
class Program:
    """A template that was read.

    Args:
        body: Its work.
        names: The names that it looks up.
        weight: The work of going through all of it once, in steps.
    """

    __slots__ = ("_body", "_weight", "names")

    def __init__(self, body: Sequence[Execute], names: frozenset[str], weight: int) -> None:
        self._body = tuple(body)
        self._weight = weight
        self.names = names

    def render(self, variables: Mapping[str, object], now: datetime | None) -> str:
        """Return the text that it writes; see :meth:`Template.render`."""
        run = Run(variables, now)
        try:
            run.spend(self._weight)
            for statement in self._body:
                statement(run)
        except RecursionError:
            raise TemplateError("a value is nested too deeply") from None
        except (TypeError, ArithmeticError) as error:
            raise TemplateError(f"the values do not fit the template: {str(error)[:_MOST_SHOWN]}") from error
        except (ValueError, LookupError, AttributeError) as error:
            # Their messages may show a value, which may be the code of a lock.
            raise TemplateError(f"the values do not fit the template: {type(error).__name__}") from None
        return run.written()


_MOST_SHOWN = 80
