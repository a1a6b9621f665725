"""Python's two ways to format a text, where no width is large and nothing is looked into."""

from __future__ import annotations

import re
from string import Formatter

from homebot.conventions.jinja.errors import TemplateError

__all__ = ["braces", "percent", "strftime_format"]


def percent(template: str, values: object) -> str:
    """Return ``template % values``.

    Raises:
        TemplateError: A width is taken from the values, or has more than two digits.
        TypeError: The values do not fit.
        ValueError: The values do not fit, or the template is none.
    """
    for width in _PERCENT.findall(template):
        if "*" in width or _LARGE.search(width):
            raise TemplateError("a text is formatted to a large width")
    return template % values


def braces(template: str, values: tuple[object, ...], named: dict[str, object]) -> str:
    """Return ``template.format(*values, **named)``.

    Raises:
        TemplateError: A field looks into its value, or a width is taken from the values, or has more than two digits.
        LookupError: A value is missing.
        TypeError: The values do not fit.
        ValueError: The values do not fit, or the template is none.
    """
    for _, field, width, _ in Formatter().parse(template):
        if field is not None and not _FIELD.fullmatch(field):
            raise TemplateError("a text is formatted with more than plain values")
        if width and ("{" in width or _LARGE.search(width)):
            raise TemplateError("a text is formatted to a large width")
    return template.format(*values, **named)


def strftime_format(template: str) -> str:
    """Return *template*, a format of times, as it is.

    Raises:
        TemplateError: It is long, or asks for more than plain fields.
    """
    if len(template) > _LONGEST_TIME or not _TIME.fullmatch(template):
        raise TemplateError("a time is formatted with more than plain fields")
    return template


_PERCENT = re.compile(r"%(?:\([^)]*\))?[-+ #0]*([0-9*]*(?:\.[0-9*]*)?)")
_LARGE = re.compile(r"[0-9]{3}")
_FIELD = re.compile(r"[A-Za-z0-9_]{0,32}")
_LONGEST_TIME = 64
_TIME = re.compile(r"(?:[^%]|%-?[A-Za-z%])*")
