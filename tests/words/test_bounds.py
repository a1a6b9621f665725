"""What a stranger writes costs as much as it is long."""

import importlib
import pkgutil
import re
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from re import _constants as codes  # type: ignore[attr-defined]
from re import _parser as parser  # type: ignore[attr-defined]
from typing import Any

import pytest
from tests.call_counts import calls

import homebot.words
from homebot.errors import UsageError
from homebot.words.conditions import read_condition
from homebot.words.exact_queries import parse_cautious_query
from homebot.words.message_values import read_message
from homebot.words.patterns import read_pattern
from homebot.words.queries import parse_query
from homebot.words.steps import read_step
from homebot.words.tokens import MAX_QUERY, Phrase
from homebot.words.triggers import read_trigger
from homebot.words.wishes import KnownNames, read_wishes

READERS: tuple[tuple[Callable[[str], object], str], ...] = (
    (parse_query, "(not "),
    (parse_query, "is is below "),
    (parse_cautious_query, "on a "),
    (parse_cautious_query, "(not on "),
    (read_trigger, "no temperature in "),
    (read_trigger, "x press for 1 "),
    (read_trigger, "message on x with = "),
    (read_trigger, "x of x rises above x of x plus 1 "),
    (lambda text: read_trigger(f"{text}changes"), "a "),
    (lambda text: read_message(f"{{{text}}}"), "a "),
    (read_condition, "nobody is sleeps in or "),
    (read_step, "wait until x, at most "),
    (read_step, "and then a on, 1, "),
    (lambda text: read_wishes(text, KnownNames()), "is at the dock and "),
    (read_pattern, "turn on not "),
)


@pytest.mark.parametrize(("read", "piece"), READERS)
def test_a_text_that_is_too_long_is_refused_at_once(read: Callable[[str], object], piece: str) -> None:
    def work() -> None:
        with pytest.raises(UsageError):
            read(piece * (20_000 // len(piece)))

    assert calls(work) < 20 * MAX_QUERY


@pytest.mark.parametrize(
    "piece", ["on ", "a ", "tv on ", "x is ", "a or b on or ", "(a) ", "not (on and ", "salt on lights "]
)
def test_a_ban_costs_as_much_as_its_text_is_long(piece: str) -> None:
    """Each of its words that may be a name was read as a query of its own."""

    def count(pieces: int) -> int:
        def work() -> None:
            with suppress(UsageError):
                parse_cautious_query(piece * pieces + "end")

        return calls(work)

    most = 90 // len(piece.split())
    assert count(most) < 2.5 * count(most // 2)


@pytest.mark.parametrize("piece", ["1 2 ", "on off ", "heat 1 ", "set to "])
def test_a_step_costs_little_more_than_its_text_is_long(piece: str) -> None:
    """What stood after each of its words was read as a command, as long as it was."""

    def count(pieces: int) -> int:
        def work() -> None:
            with suppress(UsageError):
                read_step((piece * pieces).strip())

        return calls(work)

    count(120)  # what is cached is read once
    assert count(121) < 2.5 * count(61)


def test_a_form_costs_as_much_as_its_text_is_long() -> None:
    form = Phrase("{first} for {second} for {third} for {fourth} for [x] end")

    def count(length: int) -> int:
        return calls(lambda: form.match("for " * length))

    assert count(200) < 2.2 * count(100)


def test_no_expression_repeats_what_repeats() -> None:
    expressions = [value for module in _modules() for value in vars(module).values() if isinstance(value, re.Pattern)]
    assert expressions
    for expression in expressions:
        assert not _is_nested(parser.parse(expression.pattern, expression.flags), is_inside=False), expression.pattern


FORMATS = {
    "features/alerts/alert_table.py",
    "features/bags",
    "features/machine/command.py",
    "features/routines/text.py",
    "control/journal/given_codes.py",
    "devices/identity.py",
}
"""Where expressions read files and messages of programs, in the folders that are about people's words."""


def test_what_people_write_is_read_by_words_alone() -> None:
    """Other readers combine tokens and phrases, and have no expressions."""
    source = Path(homebot.__file__).parent
    folders = ("apps", "command_words", "control", "devices", "features", "robots")
    readers = [path for folder in folders for path in source.glob(f"{folder}/**/*.py")]
    readers += [source / f"cli/commands/{verb}.py" for verb in ("do", "why", "find")]
    with_expressions = {
        path.relative_to(source).as_posix() for path in readers if "import re\n" in path.read_text("utf-8")
    }
    assert {path for path in with_expressions if not path.startswith(tuple(FORMATS))} == set()
    there = [place for place in FORMATS if source.joinpath(*place.split("/")[:2]).exists()]  # a folder may be taken out
    assert all(any(path.startswith(place) for path in with_expressions) for place in there)


def _modules() -> Iterator[Any]:
    for module in pkgutil.iter_modules(homebot.words.__path__):
        yield importlib.import_module(f"homebot.words.{module.name}")


def _is_nested(items: Any, *, is_inside: bool) -> bool:
    """Return whether an unbounded repetition is in another one."""
    for code, argument in items:
        is_loop = code in {codes.MAX_REPEAT, codes.MIN_REPEAT} and argument[1] == codes.MAXREPEAT
        if is_loop and is_inside:
            return True
        inner = argument if isinstance(argument, tuple | list) else ()
        for part in (*inner, *(choice for choices in inner if isinstance(choices, list) for choice in choices)):
            if isinstance(part, parser.SubPattern) and _is_nested(part, is_inside=is_inside or is_loop):
                return True
    return False
