"""A routine as an app in Python, with its test. Pure."""

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from keyword import iskeyword
from typing import Final

from homebot.features.routines.program import (
    Back,
    Block,
    Branch,
    Choice,
    ForEach,
    NextTurn,
    RepeatedSteps,
    Skip,
    StepsForEach,
    program_of,
)
from homebot.features.routines.settings import RoutineSettings
from homebot.features.routines.text import read_settings
from homebot.support.folding import words_of
from homebot.words.steps import Stop, WaitFor, WaitUntil, read_step

_TAKEN: Final = frozenset({"homebot", "pytest"})
_INDENT: Final = " " * 8
_MAX_CHOICES: Final = 3
"""Choices of which the test takes every way; of more, only two."""


def app_files(text: str, source: str, app: str) -> tuple[Mapping[str, str], str]:
    """Return the files of the routine *text* by name, the test last, and the app's ``class`` in a configuration."""
    settings, module = read_settings(text, source), module_name(app)
    files = {f"{module}.py": app_text(settings), f"test_{module}.py": pytest_text(settings, module)}
    return files, f"{module}.py:{class_name(settings)}"


def class_name(routine: RoutineSettings) -> str:
    """Return the name of the class, such as ``HallLight``."""
    name = "".join(word.title() for word in words_of(routine.name) if word.isascii())
    return name if name[:1].isalpha() else f"Routine{name}"


def module_name(app: str) -> str:
    """Return the name of the module for the routine *app*, which no other module has, and which can be imported."""
    is_taken = iskeyword(app) or app in sys.stdlib_module_names or app in _TAKEN
    return f"routine_{app}" if is_taken else app


def app_text(routine: RoutineSettings) -> str:
    """Return the file of the app."""
    facts = [f"when = {_tuple(routine.when)}"]
    if routine.conditions:
        facts.append(f"conditions = {_tuple(routine.conditions)}")
    if routine.mode != "single":
        facts.append(f'mode = "{routine.mode}"')
    lines = [
        f'"""{_prose(routine.name)}: a routine as an app, which you may change."""',
        "",
        "from homebot.apps import RoutineApp",
        "",
        "",
        f"class {class_name(routine)}(RoutineApp):",
        *(f"    {fact}" for fact in facts),
        "",
        "    async def perform(self) -> None:",
        *_body(routine.do),
    ]
    return "\n".join(lines) + "\n"


def pytest_text(routine: RoutineSettings, module: str) -> str:
    """Return the file of its test, which expects the steps of the routine on every way through its choices."""
    name = class_name(routine)
    choices = [*_choices(routine.do)]
    ways = list(product((True, False), repeat=len(choices)))
    ways = ways if len(choices) <= _MAX_CHOICES else [ways[0], ways[-1]]
    checks = dict(_way(routine.do, one) for one in ways)
    lines = [
        f'"""The app {name} takes the steps of the routine."""',
        "",
        "import asyncio",
        "",
        f"from {module} import {name}",
        "",
        "from homebot.testing import steps_of",
        "",
        "",
        "def test_it_takes_the_steps_of_the_routine() -> None:",
    ]
    for holds, steps in checks.items():
        given = f", holds={_list(holds)}" if holds else ""
        lines += [f"    assert asyncio.run(steps_of({name}{given})) == {_list(steps)}"]
    return "\n".join(lines) + "\n"


def _choices(steps: Sequence[str | Block]) -> Iterator[Choice]:
    for one in steps:
        if not isinstance(one, str):
            yield from (one,) if isinstance(one, Choice) else ()
            yield from _choices(one.do)
            yield from _choices(one.otherwise if isinstance(one, Choice) else ())


def _body(steps: Sequence[str | Block], indent: str = _INDENT, word: str = "if") -> Iterator[str]:
    for one in steps:
        if isinstance(one, str):
            match read_step(one):
                case Stop():
                    yield f"{indent}return"
                case WaitFor(stops=True) | WaitUntil(stops=True):
                    yield f"{indent}if not await self.step({one!r}):"
                    yield f"{indent}    return"
                case _:
                    yield f"{indent}await self.step({one!r})"
            continue
        if isinstance(one, StepsForEach):
            yield f"{indent}async for _ in self.turns({one.devices!r}):"
            yield from _body(one.do, f"{indent}    ")
            continue
        if isinstance(one, RepeatedSteps):
            conditions = ", ".join(map(repr, one.as_long_as or one.until))
            if one.times:
                yield f"{indent}for _ in range({one.times}):"
            else:
                yield f"{indent}while {f'await self.holds({conditions})' if one.as_long_as else True}:"
            yield from _body(one.do, f"{indent}    ")
            if one.until:
                yield f"{indent}    if await self.holds({conditions}):"
                yield f"{indent}        break"
            continue
        yield f"{indent}{word} await self.holds({', '.join(map(repr, one.conditions))}):"
        yield from _body(one.do, f"{indent}    ")
        if len(one.otherwise) == 1 and isinstance(one.otherwise[0], Choice):
            yield from _body(one.otherwise, indent, "elif")
        elif one.otherwise:
            yield f"{indent}else:"
            yield from _body(one.otherwise, f"{indent}    ")


def _way(steps: Sequence[str | Block], taken: Sequence[bool]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return the conditions that hold on a way through the choices, and its steps.

    No loop goes on while something holds, and each that goes on until something holds ends after one round.
    """
    ways = zip(_choices(steps), taken, strict=True)
    loops = [*_loops(steps)]
    holds = {text for one, is_taken in ways if is_taken for text in one.conditions}
    holds -= {text for loop in loops for text in loop.as_long_as}
    holds |= {text for loop in loops for text in loop.until}
    return tuple(sorted(holds)), tuple(_taken(steps, holds))


def _loops(steps: Sequence[str | Block]) -> Iterator[RepeatedSteps]:
    for one in steps:
        if not isinstance(one, str):
            yield from (one,) if isinstance(one, RepeatedSteps) else ()
            yield from _loops((*one.do, *(one.otherwise if isinstance(one, Choice) else ())))


def _taken(steps: Sequence[str | Block], holds: set[str]) -> Iterator[str]:
    """Yield the steps that are taken while *holds* hold, up to the end of the run."""
    program, place = program_of(steps), 0
    while place < len(program):
        text, step = program[place]
        match step:
            case Stop():
                return
            case Branch():
                place += 0 if holds.issuperset(condition for condition, _ in step.conditions) else step.over
            case Skip():
                place += step.over
            case Back():
                place -= step.over + 1
            case ForEach() | NextTurn():  # one device fits
                pass
            case _:
                yield text
        place += 1


def _tuple(texts: Sequence[str]) -> str:
    return f"({', '.join(map(repr, texts))},)"


def _list(texts: Sequence[str]) -> str:
    return f"[{', '.join(map(repr, texts))}]"


def _prose(text: str) -> str:
    """Return *text* for a docstring."""
    return text.replace("\\", "/").replace('"', "'")
