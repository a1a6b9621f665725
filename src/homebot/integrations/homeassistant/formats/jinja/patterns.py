"""Functions of templates for regular expressions, whose work is counted."""

import re

from homebot.conventions.bounded_patterns import PatternError, compile_bounded, compiling_work
from homebot.integrations.homeassistant.formats.jinja.evaluation import Run
from homebot.integrations.homeassistant.formats.jinja.values import MAX_TEXT, TemplateError, text, whole


def matches(run: Run, value: object, find: object = "", ignorecase: object = False) -> bool:
    """Return whether *value* begins with a match of *find*."""
    subject = text(value)
    return _pattern(run, find, subject, ignorecase).match(subject) is not None


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
    try:
        run.spend(compiling_work(expression))
        bounded = compile_bounded(expression, re.IGNORECASE if ignorecase else re.NOFLAG)
    except PatternError as error:
        raise TemplateError(str(error)) from error
    run.spend(bounded.work(subject))
    return bounded.pattern
