"""Regular expressions of strangers: matched only where the work of Python's ``re`` has a small known bound.

Python's matcher goes back and tries again, so some expressions take more than the age of the world. Without groups that
occur repeatedly and have something inside that repeats or branches, and without references and looking around, an
expression does no more than choose where it starts and where each repetition ends. The number of those choices is
computed before, and counted as work.
"""

import math
import re
import warnings
from contextlib import suppress
from functools import lru_cache

from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.values import MAX_TEXT, TemplateError, text, whole
from homebot.conventions.unreadable import shown
from homebot.errors import RefusedError

__all__ = ["COMPILING", "find_all", "find_all_index", "matches", "replaces", "require_match", "searches"]

_LONGEST = 200
COMPILING = 200
"""Steps for what a regular expression takes to be compiled."""

_WIDE_RANGE = re.compile(r"-(?:[^\x00-\xff]|\\[uUN])")
"""Python goes through all characters of such a range one by one."""

_COMPILING_RANGE = 5000
_PLACES_PER_STEP = 100


def matches(run: Run, value: object, find: object = "", ignorecase: object = False) -> bool:
    """Return whether *value* begins with a match of *find*."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).match(subject) is not None


def require_match(value: str, pattern: object) -> None:
    """Refuse a text that does not begin with a match of *pattern*, as Home Assistant does.

    A pattern that is none, or whose work has no small bound, is left to the device.
    """
    with suppress(TemplateError):
        if isinstance(pattern, str) and not matches(Run({}), value, pattern):
            raise RefusedError("text", f"it takes a text that matches {shown(pattern)}")


def searches(run: Run, value: object, find: object = "", ignorecase: object = False) -> bool:
    """Return whether *value* has a match of *find* somewhere."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).search(subject) is not None


def replaces(run: Run, value: object = "", find: object = "", replace: object = "", ignorecase: object = False) -> str:
    """Return *value* with every match of *find* replaced."""
    subject, replacement = text(value), text(replace)
    pattern = _pattern(run, find, subject, ignorecase)
    # Matches lie side by side, so that all that one reference gives is no longer than the value.
    longest = (len(subject) + 1) * (len(replacement) + 1) + replacement.count("\\") * len(subject)
    if longest > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    try:
        return pattern.sub(replacement, subject)
    except re.error as error:
        raise TemplateError("a regular expression has a wrong replacement") from error


def find_all(run: Run, value: object, find: object = "", ignorecase: object = False) -> list[object]:
    """Return every match of *find* in *value*; its groups where it has any."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).findall(subject)


def find_all_index(run: Run, value: object, find: object = "", index: object = 0, ignorecase: object = False) -> object:
    """Return one of the matches that :func:`find_all` gives."""
    return find_all(run, value, find, ignorecase)[whole(index)]


def _pattern(run: Run, find: object, subject: str, ignorecase: object) -> re.Pattern[str]:
    expression = text(find)
    if len(expression) > _LONGEST:
        raise TemplateError(f"a regular expression has more than {_LONGEST} characters")
    run.spend(COMPILING + _COMPILING_RANGE * len(_WIDE_RANGE.findall(expression)))
    repeats, branches, pattern = _compiled(expression, re.IGNORECASE if ignorecase else re.NOFLAG)
    # The places where a match starts and where each repetition ends are in order; at each, the fixed rest is tried.
    ends = math.comb(len(subject) + repeats + 1, repeats + 1) << branches
    places = ends * (1 + min(len(subject), len(expression)) // 4)
    run.spend(places // _PLACES_PER_STEP)
    return pattern


@lru_cache(maxsize=64)
def _compiled(expression: str, flags: re.RegexFlag) -> tuple[int, int, re.Pattern[str]]:
    try:
        # Python warns of sets such as "[[]", which are allowed.
        with warnings.catch_warnings(action="ignore"):
            pattern = re.compile(expression, flags)
    except (re.error, RecursionError, OverflowError) as error:
        raise TemplateError("a regular expression is wrong") from error
    return *_complexity(expression), pattern


def _complexity(expression: str) -> tuple[int, int]:
    """Return how many repetitions and branches *expression* has.

    Raises:
        TemplateError: A construct in it makes its work unbounded.
    """
    repeats = branches = 0
    groups: list[bool] = []
    ended_group_is_simple = True
    for one in _TOKEN.findall(expression):
        if one in _QUANTIFIERS or one[0] == "{":
            if one != "?" and not ended_group_is_simple:
                raise TemplateError("a regular expression nests repetitions")
            groups = [False] * len(groups)
            repeats, branches = repeats + (one != "?"), branches + (one == "?")
        elif one == "|":
            groups = [False] * len(groups)
            branches += 1
        elif one[0] == "(":
            groups.append(True)
        ended_group_is_simple = groups.pop() if one == ")" and groups else True
        if one in _UNBOUNDED or _REFERENCE.fullmatch(one):
            raise TemplateError("a regular expression looks around or refers to its groups")
    return repeats, branches


_TOKEN = re.compile(r"\\.|\[\^?\]?(?:\\.|[^\]\\])*\]|\{[0-9]*,?[0-9]*\}|\(\?:|\(\?P<\w+>|\(\?|.", re.DOTALL)
_QUANTIFIERS = frozenset("*+?")
_UNBOUNDED = frozenset({"(?"})
_REFERENCE = re.compile(r"\\[1-9]")
