"""The tests of the language: the words after ``is``. Pure."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime
from typing import Final

from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.numbers import BINARY, ORDER, is_number
from homebot.conventions.jinja.patterns import matches, searches
from homebot.conventions.jinja.values import Undefined, text

__all__ = ["CHECKS"]


def _order(operator: str) -> Callable[..., object]:
    compare = ORDER[operator]
    return lambda _, value, other: compare(value, other)


def _kind(*kinds: type) -> Callable[..., object]:
    return lambda _, value: isinstance(value, kinds)


def _divisible(_: Run, value: object, by: object) -> bool:
    return BINARY["Mod"](value, by) == 0


def _remains(remainder: int) -> Callable[..., object]:
    return lambda _, value: BINARY["Mod"](value, 2) == remainder


def _contains(_: Run, value: object, one: object) -> object:
    return ORDER["in"](one, value)


_ORDERS: Final = {
    "eq": ("==", "eq", "equalto"),
    "ne": ("!=", "ne"),
    "lt": ("<", "lt", "lessthan"),
    "lteq": ("<=", "le"),
    "gt": (">", "gt", "greaterthan"),
    "gteq": (">=", "ge"),
    "in": ("in",),
}
"""Names of each comparison."""

CHECKS: Final[dict[str, Callable[..., object]]] = {
    **{name: _order(operator) for operator, names in _ORDERS.items() for name in names},
    "boolean": _kind(bool),
    "contains": _contains,
    "datetime": _kind(datetime),
    "defined": lambda _, value: not isinstance(value, Undefined),
    "divisibleby": _divisible,
    "even": _remains(0),
    "false": lambda _, value: value is False,
    "float": _kind(float),
    "integer": lambda _, value: isinstance(value, int) and not isinstance(value, bool),
    "is_number": is_number,
    "iterable": _kind(str, bytes, list, tuple, dict, Undefined),
    "list": _kind(list),
    "lower": lambda _, value: text(value).islower(),
    "mapping": _kind(dict),
    "match": matches,
    "none": lambda _, value: value is None,
    "number": _kind(int, float),
    "odd": _remains(1),
    "sameas": lambda _, value, other: value is other,
    "search": searches,
    "sequence": _kind(str, bytes, list, tuple, dict, Undefined),
    "string": _kind(str),
    "string_like": _kind(str, bytes),
    "true": lambda _, value: value is True,
    "tuple": _kind(tuple),
    "undefined": _kind(Undefined),
    "upper": lambda _, value: text(value).isupper(),
}
"""By name; each takes the run and the value first."""
