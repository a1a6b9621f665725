"""Arithmetic as Python has it, where no result can be large. Bounds on numbers are checked by :meth:`Run.handle`."""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Final

from homebot.conventions.jinja.errors import TemplateError
from homebot.conventions.jinja.formatting import percent
from homebot.conventions.jinja.limits import MAX_ITEMS, MAX_NUMBER_BITS, MAX_TEXT

__all__ = ["BINARY", "ORDER"]

Binary = Callable[..., object]


def _multiply(left: object, right: object) -> object:
    for many, times in ((left, right), (right, left)):
        if isinstance(many, (str, bytes, list, tuple)) and isinstance(times, int):
            limit = MAX_TEXT if isinstance(many, (str, bytes)) else MAX_ITEMS
            if len(many) * times > limit:
                raise TemplateError(f"a value is repeated to more than {limit}")
    return _python_multiply(left, right)


def _power(base: object, exponent: object) -> object:
    if isinstance(base, int) and isinstance(exponent, int) and base.bit_length() * exponent > MAX_NUMBER_BITS:
        raise TemplateError(f"a number has more than {MAX_NUMBER_BITS} bits")
    return _python_power(base, exponent)


def _remainder(left: object, right: object) -> object:
    if isinstance(left, str):
        return percent(left, right)
    if isinstance(left, bytes):
        raise TypeError("bytes are not formatted")
    return _python_remainder(left, right)


_python_multiply: Binary = operator.mul
_python_power: Binary = operator.pow
_python_remainder: Binary = operator.mod

BINARY: Final[dict[str, Binary]] = {
    "Add": operator.add,
    "Sub": operator.sub,
    "Mul": _multiply,
    "Div": operator.truediv,
    "FloorDiv": operator.floordiv,
    "Mod": _remainder,
    "Pow": _power,
}
"""The binary operators, by Jinja's names of them. They raise what Python raises, or TemplateError."""

ORDER: Final[dict[str, Binary]] = {
    "eq": operator.eq,
    "ne": operator.ne,
    "lt": operator.lt,
    "lteq": operator.le,
    "gt": operator.gt,
    "gteq": operator.ge,
    "in": lambda one, many: operator.contains(_container(many), one),
    "notin": lambda one, many: not operator.contains(_container(many), one),
}
"""The comparisons, by Jinja's names of them."""


def _container(many: object) -> list[object] | str | tuple[object, ...] | dict[object, object]:
    if isinstance(many, (str, list, tuple, dict)):
        return many
    if not many and hasattr(many, "__iter__"):
        return ()
    raise TypeError(f"nothing can be in a {type(many).__name__}")
