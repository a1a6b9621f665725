"""The methods of texts, lists and mappings, and Python's two ways to format a text, where no width is large. Pure."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from datetime import datetime, timedelta
from string import Formatter
from typing import Final

from homebot.conventions.jinja.limits import MAX_ITEMS, MAX_TEXT, TemplateError

__all__ = ["METHODS", "join", "method_of", "percent", "replace", "strftime_format"]


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


def _braces(template: str, values: tuple[object, ...], named: dict[str, object]) -> str:
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


def method_of(value: object, method: str) -> Callable[..., object]:
    """Return the method of that name of values such as *value*; it takes the value first.

    Raises:
        TemplateError: There is none.
    """
    for kind, methods in METHODS.items():
        if isinstance(value, kind) and method in methods:
            return methods[method]
    raise TemplateError(f"a {type(value).__name__} has no method {method}()")


def replace(value: str, old: str, new: str, count: int = -1) -> str:
    """Return ``value.replace(old, new, count)``.

    Raises:
        TemplateError: The result is too long.
    """
    times = value.count(old)
    if count >= 0:
        times = min(times, count)
    if len(value) + times * (len(new) - len(old)) > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    return value.replace(old, new, count)


def join(separator: str, values: Iterable[str]) -> str:
    """Return ``separator.join(values)``.

    Raises:
        TemplateError: The result is too long.
    """
    values = list(values)
    if len(separator) * len(values) + sum(map(len, values)) > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    return separator.join(values)


def _split(value: str, separator: str | None = None, maxsplit: int = -1) -> list[str]:
    limit = MAX_ITEMS if maxsplit < 0 else min(maxsplit, MAX_ITEMS)
    return value.split(separator, limit)


def _rsplit(value: str, separator: str | None = None, maxsplit: int = -1) -> list[str]:
    limit = MAX_ITEMS if maxsplit < 0 else min(maxsplit, MAX_ITEMS)
    return value.rsplit(separator, limit)


def _padding(pad: Callable[..., str]) -> Callable[..., str]:
    def padded(value: str, width: int, *fill: str) -> str:
        if width > MAX_TEXT:
            raise TemplateError(f"a text has more than {MAX_TEXT} characters")
        return pad(value, width, *fill)

    return padded


def _strftime(value: datetime, template: str) -> str:
    return value.strftime(strftime_format(template))


_TEXT: Final[dict[str, Callable[..., object]]] = {
    "capitalize": str.capitalize,
    "center": _padding(str.center),
    "count": str.count,
    "endswith": str.endswith,
    "find": str.find,
    "format": lambda value, *values, **named: _braces(value, values, named),
    "index": str.index,
    "isalnum": str.isalnum,
    "isalpha": str.isalpha,
    "isdecimal": str.isdecimal,
    "isdigit": str.isdigit,
    "islower": str.islower,
    "isnumeric": str.isnumeric,
    "isupper": str.isupper,
    "join": join,
    "ljust": _padding(str.ljust),
    "lower": str.lower,
    "lstrip": str.lstrip,
    "partition": str.partition,
    "removeprefix": str.removeprefix,
    "removesuffix": str.removesuffix,
    "replace": replace,
    "rfind": str.rfind,
    "rjust": _padding(str.rjust),
    "rpartition": str.rpartition,
    "rsplit": _rsplit,
    "rstrip": str.rstrip,
    "split": _split,
    "splitlines": str.splitlines,
    "startswith": str.startswith,
    "strip": str.strip,
    "swapcase": str.swapcase,
    "title": str.title,
    "upper": str.upper,
    "zfill": _padding(str.zfill),
}

METHODS: Final[dict[type, dict[str, Callable[..., object]]]] = {
    str: _TEXT,
    dict: {
        "get": dict.get,
        "items": lambda value: list(value.items()),
        "keys": list,
        "values": lambda value: list(value.values()),
    },
    list: {"count": list.count, "index": list.index},
    tuple: {"count": tuple.count, "index": tuple.index},
    float: {"is_integer": float.is_integer},
    datetime: {
        "isoformat": datetime.isoformat,
        "isoweekday": datetime.isoweekday,
        "strftime": _strftime,
        "timestamp": datetime.timestamp,
        "weekday": datetime.weekday,
    },
    timedelta: {"total_seconds": timedelta.total_seconds},
}
"""By the type of the value, by name."""
