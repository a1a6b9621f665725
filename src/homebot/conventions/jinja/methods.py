"""The methods of values that a template may call: none of them changes its value or makes a large one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from datetime import datetime, timedelta
from typing import Final

from homebot.conventions.jinja.errors import TemplateError
from homebot.conventions.jinja.formatting import braces, strftime_format
from homebot.conventions.jinja.limits import MAX_ITEMS, MAX_TEXT

__all__ = ["METHODS", "join", "method_of", "replace"]


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
    "format": lambda value, *values, **named: braces(value, values, named),
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
