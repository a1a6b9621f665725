"""Expressions of a template: each function here makes one that, given a run, gives its value.

Work that costs more than a moment is counted with the run: a function, a method and an operator have the size of their
values counted before, if that decides their cost, and the size of their result after.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeAlias

from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.methods import method_of
from homebot.conventions.jinja.numbers import BINARY, ORDER
from homebot.conventions.jinja.values import Undefined, item, text, whole

__all__ = [
    "Evaluate",
    "Function",
    "binary",
    "call",
    "call_method",
    "comparison",
    "concatenation",
    "condition",
    "conjunction",
    "constant",
    "disjunction",
    "listing",
    "lookup",
    "mapping",
    "name",
    "negation",
    "part",
    "sign",
]

Evaluate: TypeAlias = Callable[[Run], object]
Function: TypeAlias = Callable[..., object]
"""Takes the run, then its arguments; raises Python's errors for wrong values."""


def constant(value: object) -> Evaluate:
    """Evaluate a value that is written in the template; it is handled already, and nothing can change it."""
    return lambda _: value


def name(name_: str, otherwise: object) -> Evaluate:
    """Evaluate a name; *otherwise* where it has no value."""

    def evaluate(run: Run) -> object:
        value = run.lookup(name_)
        return otherwise if isinstance(value, Undefined) else value

    return evaluate


def listing(items: Sequence[Evaluate], kind: Callable[[list[object]], object]) -> Evaluate:
    """Evaluate a list or tuple, as *kind* makes it."""
    return lambda run: run.handle(kind([one(run) for one in items]))


def mapping(items: Sequence[tuple[Evaluate, Evaluate]]) -> Evaluate:
    """Evaluate a mapping; the last of equal keys counts."""
    return lambda run: run.handle({key(run): value(run) for key, value in items})


def lookup(value: Evaluate, key: Evaluate) -> Evaluate:
    """Return the value of a container at a key; see :func:`item`."""
    return lambda run: item(value(run), key(run))


def part(value: Evaluate, bounds: Sequence[Evaluate]) -> Evaluate:
    """Evaluate a slice of a list or text: from, to and step."""

    def evaluate(run: Run) -> object:
        many = value(run)
        if isinstance(many, Undefined):
            many.fail()
        if not isinstance(many, (str, bytes, list, tuple)):
            raise TypeError(f"a {type(many).__name__} cannot be indexed")
        start, stop, step = [_index(bound(run)) for bound in bounds]
        return run.handle(many[start:stop:step])

    return evaluate


def binary(operator: str, left: Evaluate, right: Evaluate) -> Evaluate:
    """Evaluate an operation of :data:`BINARY`."""
    operate = BINARY[operator]
    return lambda run: run.handle(operate(run.handle(left(run)), run.handle(right(run))))


def sign(operator: Callable[..., object], value: Evaluate) -> Evaluate:
    """Evaluate a sign before a number."""
    return lambda run: operator(value(run))


def negation(value: Evaluate) -> Evaluate:
    """Evaluate ``not``."""
    return lambda run: not value(run)


def conjunction(left: Evaluate, right: Evaluate) -> Evaluate:
    """Evaluate ``and``, which gives one of its values, as in Python."""
    return lambda run: left(run) and right(run)


def disjunction(left: Evaluate, right: Evaluate) -> Evaluate:
    """Evaluate ``or``, which gives one of its values, as in Python."""
    return lambda run: left(run) or right(run)


def condition(test: Evaluate, yes: Evaluate, no: Evaluate) -> Evaluate:
    """Evaluate ``yes if test else no``."""
    return lambda run: yes(run) if test(run) else no(run)


def comparison(first: Evaluate, others: Sequence[tuple[str, Evaluate]]) -> Evaluate:
    """Evaluate a chain of comparisons of :data:`ORDER`, as in Python."""
    steps = [(ORDER[operator], value) for operator, value in others]

    def evaluate(run: Run) -> object:
        left = first(run)
        result: object = True
        for compare, value in steps:
            right = value(run)
            result = compare(_counted(run, left), _counted(run, right))
            if not result:
                break
            left = right
        return result

    return evaluate


def concatenation(values: Sequence[Evaluate]) -> Evaluate:
    """Evaluate ``~``: the texts of all values as one."""

    def evaluate(run: Run) -> object:
        return run.handle("".join([text(run.handle(value(run))) for value in values]))

    return evaluate


def call(function: Function, arguments: Sequence[Evaluate], named: Sequence[tuple[str, Evaluate]]) -> Evaluate:
    """Evaluate a call of a filter, a test or a function."""
    if not named:
        return lambda run: run.handle(function(run, *[run.handle(one(run)) for one in arguments]))

    def evaluate(run: Run) -> object:
        values = [run.handle(one(run)) for one in arguments]
        return run.handle(function(run, *values, **{key: run.handle(one(run)) for key, one in named}))

    return evaluate


def call_method(
    owner: Evaluate, method: str, arguments: Sequence[Evaluate], named: Sequence[tuple[str, Evaluate]]
) -> Evaluate:
    """Evaluate a call of a method of a value; see :func:`method_of`."""

    def evaluate(run: Run) -> object:
        value = run.handle(owner(run))
        if isinstance(value, Undefined):
            value.fail()
        values = [run.handle(one(run)) for one in arguments]
        return run.handle(method_of(value, method)(value, *values, **{key: run.handle(one(run)) for key, one in named}))

    return evaluate


def _index(value: object) -> int | None:
    return None if value is None else whole(value)


def _counted(run: Run, value: object) -> object:
    return run.handle(value) if isinstance(value, (list, tuple, dict)) else value
