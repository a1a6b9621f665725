"""No regular expression needs more than linear time, whatever is sent: each meets texts made to slow it down."""

import ast
import importlib
import pkgutil
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from re import _constants as ops  # type: ignore[attr-defined]  # the parsed form of a pattern, as re compiles it
from re import _parser as parser  # type: ignore[attr-defined]
from time import process_time
from typing import Any, Final, TypeAlias

import pytest
from tests.turns import slowness

import homebot

SOURCE: Final = Path(homebot.__file__).parent
MAX_CHARACTERS: Final = 4000
MAX_S: Final = 0.01
"""Linear ones take less than a millisecond, quadratic ones 30."""

SEARCHES: Final = r"\.(?:search|sub|subn|split|findall|finditer)\("
PUMPS: Final = ("a", " ", "1", "1.", "a ", '"a"', '"', "(a)", "(", "a,", "a and ", "in ", "is ", "\n", "-", "[", "é")
ENDS: Final = ("", "\n!", "\0")

Pattern: TypeAlias = re.Pattern[Any]


def _patterns() -> Iterator[tuple[str, Pattern, bool]]:
    """Yield each expression of the source, with its place, and whether it is searched for."""
    for module in pkgutil.walk_packages(homebot.__path__, "homebot."):
        if module.name.endswith("__main__"):
            continue
        try:
            loaded = importlib.import_module(module.name)
        except ModuleNotFoundError as exc:  # of an extra that only CI installs, as mcp
            if (exc.name or "").startswith("homebot"):
                raise
            continue
        text = Path(str(loaded.__file__)).read_text()
        for name, value in vars(loaded).items():
            for one in value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else (value,):
                if isinstance(one, re.Pattern):
                    yield f"{module.name}.{name}", one, bool(re.search(rf"\b{name}(?:\[.*\])?{SEARCHES}", text))
        for call in ast.walk(ast.parse(text)):
            match call:
                case ast.Call(
                    ast.Attribute(ast.Name("re"), method), [ast.Constant(str() | bytes() as literal), *_]
                ) if method not in {"compile", "escape"}:
                    found = re.compile(literal, re.VERBOSE if "VERBOSE" in ast.unparse(call) else 0)
                    yield f"{module.name}:{call.lineno}", found, method not in {"match", "fullmatch"}


def _sample(tree: Iterable[Any]) -> str:
    """Return a text that the parsed expression *tree* matches, or nearly."""
    text = ""
    for op, value in tree:
        match op:
            case ops.LITERAL:
                text += chr(value)
            case ops.ANY | ops.NOT_LITERAL:
                text += "a"
            case ops.IN:
                text += next((one for one in "a1 .,é-" if _has(value, one)), "a")
            case ops.MAX_REPEAT | ops.MIN_REPEAT | ops.POSSESSIVE_REPEAT:
                text += _sample(value[2]) * max(value[0], 1)
            case ops.SUBPATTERN:
                text += _sample(value[3])
            case ops.ATOMIC_GROUP:
                text += _sample(value)
            case ops.BRANCH:
                text += _sample(value[1][0])
    return text


def _has(items: list[tuple[Any, Any]], character: str) -> bool:
    state = parser.State()
    state.str = ""
    tree = parser.SubPattern(state, [(ops.IN, items)])
    return bool(re._compiler.compile(tree, 0).match(character))  # type: ignore[attr-defined]


def _attacks(tree: Iterable[Any], before: str = "") -> Iterator[tuple[str, str]]:
    """Yield what to send before a repeat, and what to repeat."""
    for op, value in tree:
        match op:
            case ops.MAX_REPEAT | ops.MIN_REPEAT | ops.POSSESSIVE_REPEAT:
                yield before, _sample(value[2])
                yield from _attacks(value[2], before)
            case ops.SUBPATTERN:
                yield from _attacks(value[3], before)
            case ops.BRANCH:
                for branch in value[1]:
                    yield before, _sample(branch)
                    yield from _attacks(branch, before)
        before += _sample([(op, value)])


def _slowest(pattern: Pattern, limit: float, *, is_searched: bool) -> tuple[float, str]:
    """Return the longest time that *pattern* needs in seconds, up to the first too long one, and its text."""
    tree, worst = parser.parse(pattern.pattern, pattern.flags), (0.0, "")
    attacks = {*_attacks(tree), *(("", one) for one in PUMPS)}
    attacks |= {(before, one) for before, _ in attacks for one in (" ", "a", "1")}
    call = pattern.search if is_searched else pattern.fullmatch
    for (before, pump), end in ((attack, end) for attack in sorted(attacks) if attack[1] for end in ENDS):
        count = 4
        while count * len(pump) <= MAX_CHARACTERS and worst[0] < limit:
            text = f"{before}{pump * count}{end}"
            given = text.encode(errors="replace") if isinstance(pattern.pattern, bytes) else text
            begun = process_time()
            call(given)
            worst = max(worst, (process_time() - begun, text))
            count = count + 4 if count < 40 else count * 2  # an exponential one is seen before it never ends
    return worst


def _fault(pattern: Pattern, *, is_searched: bool) -> str:
    """Return what is too slow at each of three tries; empty if one is quick enough."""
    fault = ""
    for run in range(3):
        # How slow the machine is takes longer to measure than most expressions.
        limit = MAX_S * (slowness() if run else 1.0)
        seconds, text = _slowest(pattern, limit, is_searched=is_searched)
        if seconds <= limit:
            return ""
        fault = f"{seconds * 1000:.0f} ms for {text[:60]!r}… of {len(text)} characters"
    return fault


@pytest.mark.slow
def test_no_expression_is_slow_whatever_it_is_tried_on() -> None:
    patterns = {(one.pattern, one.flags): (place, one, searched) for place, one, searched in _patterns()}
    faults = {place: _fault(one, is_searched=is_searched) for place, one, is_searched in patterns.values()}
    assert len(patterns) > 200
    assert not {place: fault for place, fault in faults.items() if fault}
