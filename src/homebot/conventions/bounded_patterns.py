"""Regular expressions of strangers: compiled only where the work of Python's ``re`` has a small known bound.

Python's matcher goes back and tries again, so some expressions take more than the age of the world. Without groups that
occur repeatedly and have something inside that repeats or branches, and without references and looking around, an
expression does no more than choose where it starts and where each repetition ends. The number of those choices is
computed before.
"""

import math
import re
import warnings
from contextlib import suppress
from functools import lru_cache
from typing import Final, NamedTuple

from homebot.conventions.unreadable import shown
from homebot.errors import RefusedError, WireError

_MAX_CHARACTERS: Final = 200
_MAX_WORK: Final = 10_000
_COMPILING: Final = 200
_COMPILING_RANGE: Final = 5000
_PLACES_PER_STEP: Final = 100

_WIDE_RANGE = re.compile(r"-(?:[^\x00-\xff]|\\[uUN])")
"""Python goes through all characters of such a range one by one."""


class PatternError(WireError):
    """A regular expression is wrong, or its work has no small bound."""


class BoundedPattern(NamedTuple):
    """A regular expression, with how many repetitions and branches it has."""

    pattern: re.Pattern[str]
    repeats: int
    branches: int

    def work(self, subject: str) -> int:
        """Return the most work of a match in *subject*, in steps of about a microsecond."""
        # The places where a match starts and where each repetition ends are in order; at each, the fixed rest is tried.
        ends = math.comb(len(subject) + self.repeats + 1, self.repeats + 1) << self.branches
        places = ends * (1 + min(len(subject), len(self.pattern.pattern)) // 4)
        return places // _PLACES_PER_STEP


def require_match(value: str, pattern: object) -> None:
    """Refuse a text that does not begin with a match of *pattern*, as Home Assistant does.

    A pattern that is none, or whose work has no small bound, is left to the device.
    """
    if not isinstance(pattern, str):
        return
    with suppress(PatternError):
        compiling = compiling_work(pattern)
        bounded = compile_bounded(pattern)
        if compiling + bounded.work(value) <= _MAX_WORK and bounded.pattern.match(value) is None:
            raise RefusedError("text", f"it takes a text that matches {shown(pattern)}")


def compiling_work(expression: str) -> int:
    """Return the work of compiling *expression*, in steps of about a microsecond.

    Raises:
        PatternError: It is too long.
    """
    if len(expression) > _MAX_CHARACTERS:
        raise PatternError(f"a regular expression has more than {_MAX_CHARACTERS} characters")
    return _COMPILING + _COMPILING_RANGE * len(_WIDE_RANGE.findall(expression))


@lru_cache(maxsize=64)
def compile_bounded(expression: str, flags: re.RegexFlag = re.NOFLAG) -> BoundedPattern:
    """Compile *expression*; consider :func:`compiling_work` first.

    Raises:
        PatternError: It is wrong, or a construct in it makes its work unbounded.
    """
    try:
        # Python warns of sets such as "[[]", which are allowed.
        with warnings.catch_warnings(action="ignore"):
            pattern = re.compile(expression, flags)
    except (re.error, RecursionError, OverflowError) as error:
        raise PatternError("a regular expression is wrong") from error
    return BoundedPattern(pattern, *_complexity(expression))


def _complexity(expression: str) -> tuple[int, int]:
    """Return how many repetitions and branches *expression* has.

    Raises:
        PatternError: A construct in it makes its work unbounded.
    """
    repeats = branches = 0
    groups: list[bool] = []
    ended_group_is_simple = True
    for symbol in _TOKEN.findall(expression):
        if symbol in _QUANTIFIERS or symbol[0] == "{":
            if symbol != "?" and not ended_group_is_simple:
                raise PatternError("a regular expression nests repetitions")
            groups = [False] * len(groups)
            repeats, branches = repeats + (symbol != "?"), branches + (symbol == "?")
        elif symbol == "|":
            groups = [False] * len(groups)
            branches += 1
        elif symbol[0] == "(":
            groups.append(True)
        ended_group_is_simple = groups.pop() if symbol == ")" and groups else True
        if symbol in _UNBOUNDED or _REFERENCE.fullmatch(symbol):
            raise PatternError("a regular expression looks around or refers to its groups")
    return repeats, branches


_TOKEN = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]|\{[0-9]*+,?[0-9]*\}|\(\?:|\(\?P<\w+>|\(\?|.", re.DOTALL)
_QUANTIFIERS = frozenset("*+?")
_UNBOUNDED = frozenset({"(?"})
_REFERENCE = re.compile(r"\\[1-9]")
