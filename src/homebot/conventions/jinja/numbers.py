"""Arithmetic as Python has it, where no result can be large, and filters and functions of numbers.

Bounds on numbers are checked by :meth:`Run.handle`. A filter with a *default* gives it for a value that is no number,
and fails without one; an undefined value fails with one too.

Source: ``homeassistant/helpers/template.py`` of Home Assistant 2025.4.4.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from typing import Final

from homebot.conventions.jinja.evaluation import Run
from homebot.conventions.jinja.limits import MAX_ITEMS, MAX_NUMBER_BITS, MAX_NUMERAL, MAX_TEXT, TemplateError
from homebot.conventions.jinja.methods import percent
from homebot.conventions.jinja.values import Undefined, real, text, whole

__all__ = ["BINARY", "MISSING", "NUMBER_CONSTANTS", "NUMBER_FILTERS", "NUMBER_FUNCTIONS", "ORDER", "is_number"]


Binary = Callable[..., object]


def _multiply(left: object, right: object) -> object:
    for many, times in ((left, right), (right, left)):
        if isinstance(many, (str, bytes, list, tuple)) and isinstance(times, int):
            limit = MAX_TEXT if isinstance(many, (str, bytes)) else MAX_ITEMS
            if len(many) * times > limit:
                raise TemplateError(f"repeating a value gives more than {limit}")
    return _python_multiply(left, right)


def _power(base: object, exponent: object) -> object:
    if isinstance(base, int) and isinstance(exponent, int) and base.bit_length() * exponent > MAX_NUMBER_BITS:
        raise TemplateError(f"a number has more than {MAX_NUMBER_BITS} bits")
    return _python_power(base, exponent)


def _remainder(left: object, right: object) -> object:
    if isinstance(left, str):
        return percent(left, right)
    if isinstance(left, bytes):
        raise TypeError("bytes cannot be formatted")
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
"""The binary operators, by Jinja's names of them. They raise Python's errors, or TemplateError."""

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
    raise TypeError(f"`in` does not work on a {type(many).__name__}")


MISSING: Final = object()
"""Stands for a default that was not given."""

_MOST_DECIMALS = 300


def is_number(_: Run, value: object) -> bool:
    """Return whether *value* is a number with an end, or the text of one."""
    try:
        return math.isfinite(real(value))
    except (ValueError, TypeError):
        return False


def _or_default(value: object, default: object, filter_: str) -> object:
    if default is MISSING:
        raise TemplateError(f"{filter_} is given a {type(value).__name__} that it cannot convert, and no default")
    return default


def _float(_: Run, value: object, default: object = MISSING) -> object:
    try:
        return real(value)
    except (ValueError, TypeError):
        return _or_default(value, default, "float")


def _int(_: Run, value: object, default: object = MISSING, base: object = 10) -> object:
    if isinstance(value, Undefined):
        value.fail()
    if isinstance(value, str) and len(value) > MAX_NUMERAL:
        return _or_default(value, default, "int")
    try:
        return int(value, whole(base)) if isinstance(value, str) else int(real(value)) if _inexact(value) else value
    except (ValueError, TypeError):
        pass
    try:
        # So that "42.23" gives 42.
        return int(real(value))
    except (ValueError, TypeError, OverflowError):
        return _or_default(value, default, "int")


def _inexact(value: object) -> bool:
    return isinstance(value, bool) or not isinstance(value, int)


def _bool(_: Run, value: object, default: object = MISSING) -> object:
    if isinstance(value, str):
        text = value[:_LONGEST_FLAG].lower().strip()
        if text in _YES or text in _NO:
            return text in _YES
    elif isinstance(value, (bool, int, float)):
        return value != 0
    return _or_default(value, default, "bool")


def _round(
    _: Run, value: object, precision: object = 0, method: object = "common", default: object = MISSING
) -> object:
    places = whole(precision)
    if abs(places) > _MOST_DECIMALS:
        raise TemplateError(f"a number is rounded to more than {_MOST_DECIMALS} places")
    try:
        multiplier = float(10**places)
        number = real(value)
        if method == "ceil":
            number = math.ceil(number * multiplier) / multiplier
        elif method == "floor":
            number = math.floor(number * multiplier) / multiplier
        elif method == "half":
            number = round(number * 2) / 2
        else:
            number = round(number, places)
        return int(number) if places == 0 else number
    except (ValueError, TypeError):
        return _or_default(value, default, "round")


def _with_amount(operate: Callable[[float, float], object], name: str) -> Callable[..., object]:
    def calculate(_: Run, value: object, amount: object, default: object = MISSING) -> object:
        try:
            return operate(real(value), _amount(amount))
        except (ValueError, TypeError):
            return _or_default(value, default, name)

    return calculate


def _amount(value: object) -> float:
    if isinstance(value, Undefined):
        value.fail()
    if not isinstance(value, (int, float)):
        raise TypeError(f"a {type(value).__name__} is not a number of seconds or a time difference")
    return value


def _of_number(calculate: Callable[[float], float], name: str) -> Callable[..., object]:
    def filter_(_: Run, value: object, default: object = MISSING) -> object:
        try:
            return calculate(real(value))
        except (ValueError, TypeError):
            return _or_default(value, default, name)

    return filter_


def _log(_: Run, value: object, base: object = math.e, default: object = MISSING) -> object:
    try:
        return math.log(real(value), real(base))
    except (ValueError, TypeError):
        return _or_default(value, default, "log")


def _abs(_: Run, value: object) -> object:
    if not isinstance(value, (int, float)):
        raise TypeError(f"abs is given a {type(value).__name__}")
    return abs(value)


def _bitwise(operate: Callable[[int, int], int]) -> Callable[..., object]:
    return lambda _, first, second: operate(whole(first), whole(second))


def _average(_: Run, values: object, default: object = MISSING) -> object:
    if not isinstance(values, (list, tuple)) or not values:
        return _or_default(values, default, "average")
    if not all(isinstance(one, (int, float)) for one in values):
        return _or_default(values, default, "average")
    return math.fsum(values) / len(values)


def _iif(_: Run, value: object, if_true: object = True, if_false: object = False, if_none: object = MISSING) -> object:
    if value is None and if_none is not MISSING:
        return if_none
    return if_true if value else if_false


def _ordinal(_: Run, value: object) -> str:
    shown = text(value)
    tens, ones = int(shown[-2:]) % 100, int(shown[-1]) % 10
    return shown + ("th" if tens in range(11, 14) else {1: "st", 2: "nd", 3: "rd"}.get(ones, "th"))


_LONGEST_FLAG = 32
_YES = frozenset({"1", "true", "yes", "on", "enable"})
_NO = frozenset({"0", "false", "no", "off", "disable"})

_CURVES: Final = {
    name: _of_number(getattr(math, name), name) for name in ("acos", "asin", "atan", "cos", "sin", "sqrt", "tan")
}

NUMBER_FUNCTIONS: Final[dict[str, Callable[..., object]]] = {
    **_CURVES,
    "bool": _bool,
    "float": _float,
    "iif": _iif,
    "int": _int,
    "is_number": is_number,
    "log": _log,
}
"""By name; each takes the run first."""

NUMBER_FILTERS: Final[dict[str, Callable[..., object]]] = {
    **NUMBER_FUNCTIONS,
    "abs": _abs,
    "add": _with_amount(lambda value, amount: value + amount, "add"),
    "average": _average,
    "bitwise_and": _bitwise(lambda first, second: first & second),
    "bitwise_or": _bitwise(lambda first, second: first | second),
    "bitwise_xor": _bitwise(lambda first, second: first ^ second),
    "multiply": _with_amount(lambda value, amount: value * amount, "multiply"),
    "ordinal": _ordinal,
    "round": _round,
}
"""By name; each takes the run and the value first."""

NUMBER_CONSTANTS: Final[dict[str, float]] = {"e": math.e, "pi": math.pi, "tau": math.tau}
"""Meanings of these names where the template and its variables say nothing else."""
