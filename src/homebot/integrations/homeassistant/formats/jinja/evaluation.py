"""Programs of templates, and their renderings: the values of names, the output, and the remaining work. Pure."""

import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from typing import TypeAlias, final

from homebot.conventions.description import work_left
from homebot.integrations.homeassistant.formats.jinja.values import (
    FREE_STEPS,
    MAX_NUMBER_BITS,
    MAX_STEPS,
    MAX_TEXT,
    UNDEFINED,
    TemplateError,
    item,
    text,
    weigh,
)


@final
class Run:
    """One rendering.

    Args:
        names: The values of the template's names at its start.

    Attributes:
        steps: Its remaining work.
    """

    __slots__ = ("_length", "_names", "_parts", "steps")

    def __init__(self, names: Mapping[str, object], steps: int = MAX_STEPS) -> None:
        self._names = dict(names)
        self._parts: list[str] = []
        self.steps = steps
        self._length = 0

    def lookup(self, name: str, default: object = UNDEFINED) -> object:
        """Return the value of *name* here, or the *default*."""
        return self._names.get(name, default)

    def assign(self, name: str, value: object) -> None:
        """Assign *value* to *name* in the innermost scope."""
        self._names[name] = value

    @contextmanager
    def scope(self) -> Iterator[None]:
        """Open a scope: its assignments end with it."""
        outer, self._names = self._names, dict(self._names)
        try:
            yield
        finally:
            self._names = outer

    def spend(self, steps: int) -> None:
        """Count work.

        Raises:
            TemplateError: It is too much.
        """
        self.steps -= steps
        if self.steps < 0:
            raise TemplateError("it does too much work")

    def spend_on_search(self, values: Iterable[object]) -> None:
        """Count the work of a function that looks for one text of *values* in another.

        Raises:
            TemplateError: It is too much.
        """
        lengths = sorted([len(value) for value in values if isinstance(value, (str, bytes))])
        if len(lengths) > 1:
            self.spend(lengths[-1] * lengths[-2] // _COMPARED_PER_STEP)

    def handle(self, value: object) -> object:
        """Return *value*, with its size counted as work.

        Raises:
            TemplateError: It is larger than a value may be.
        """
        if isinstance(value, (str, bytes)):
            if len(value) > MAX_TEXT:
                raise TemplateError(f"a text has more than {MAX_TEXT} characters")
            self.spend(1 + len(value) // 256)
        elif isinstance(value, (list, tuple, dict)):
            self.spend(1 + weigh(value) // 4)
        elif isinstance(value, int):
            if value.bit_length() > MAX_NUMBER_BITS:
                raise TemplateError(f"a number has more than {MAX_NUMBER_BITS} bits")
        elif isinstance(value, complex):
            raise TemplateError("a number is not real")
        return value

    def write(self, value: object) -> None:
        """Add the text of *value* to the output.

        Raises:
            TemplateError: The output gets too long.
        """
        if isinstance(value, (list, tuple, dict)):
            self.spend(1 + weigh(value) // 4)
        part = text(value)
        self._length += len(part)
        if self._length > MAX_TEXT:
            raise TemplateError(f"the text is longer than {MAX_TEXT} characters")
        self._parts.append(part)

    def written(self, start: int = 0) -> str:
        """Remove and return the output from *start*, a :meth:`mark`, on."""
        output = "".join(self._parts[start:])
        del self._parts[start:]
        return output

    def mark(self) -> int:
        """Return the current end of the output, for :meth:`written`."""
        return len(self._parts)


Evaluate: TypeAlias = Callable[[Run], object]
"""Evaluates an expression, or executes a statement."""

_MAX_SHOWN_CHARACTERS = 80
_COMPARED_PER_STEP = 1024


@final
class Program:
    """A compiled template.

    Args:
        names: The names that it looks up.
        weight: The work of one execution of all of it, in steps.
    """

    __slots__ = ("_body", "_weight", "names")

    def __init__(self, body: Evaluate, names: frozenset[str], weight: int) -> None:
        self._body = body
        self._weight = weight
        self.names = names

    def render(self, variables: Mapping[str, object], *, reads_message: bool = False) -> str:
        """Return its output; see :meth:`Template.render`.

        Args:
            reads_message: Whether it works on the message that this task reads, if one was begun.
        """
        free, left = FREE_STEPS + self._weight, work_left.get() if reads_message else None
        steps = MAX_STEPS if left is None else min(MAX_STEPS, free + left)
        run = Run(variables, steps)
        try:
            run.spend(self._weight)
            self._body(run)
        except RecursionError:
            raise TemplateError("a value is nested too deeply") from None
        except (TypeError, ArithmeticError) as error:
            raise TemplateError(f"the values do not fit the template: {str(error)[:_MAX_SHOWN_CHARACTERS]}") from error
        except (ValueError, LookupError, AttributeError) as error:
            # Their messages may show a value, which may be the code of a lock.
            raise TemplateError(f"the values do not fit the template: {type(error).__name__}") from None
        finally:
            if left is not None and steps - run.steps > free:
                work_left.set(max(0, left - (steps - run.steps - free)))
        return run.written()


_MAX_PATH_CHARACTERS = 100
_WEIGHT = 2
"""The weight of the name and its output; each step adds 1, and 1 for its key if that is in quotes."""

_JSON = frozenset({"value_json"})
_STEP = re.compile(r"""\.([A-Za-z_][A-Za-z_0-9]*)|\['([\w -]*)'\]|\["([\w -]*)"\]""", re.ASCII)
_PATH = re.compile(rf"\{{\{{ *value_json((?:{_STEP.pattern})+) *\}}\}}", re.ASCII)


def path_program(source: str) -> Program | None:
    """Return the program of a path such as ``{{ value_json.a['b'] }}``, as most templates are; None for any other.

    Jinja's parser takes ten times as long: 0.2 ms, for each of the thousands of templates of a large house.
    """
    if len(source) > _MAX_PATH_CHARACTERS or (match := _PATH.fullmatch(source)) is None:
        return None
    steps = _STEP.findall(match[1])
    path = tuple(map("".join, steps))

    def execute(run: Run) -> None:
        value = run.lookup("value_json")
        for key in path:
            value = item(value, key)
        run.write(value)

    return Program(execute, _JSON, _WEIGHT + sum([1 if attribute else 2 for attribute, *_ in steps]))
