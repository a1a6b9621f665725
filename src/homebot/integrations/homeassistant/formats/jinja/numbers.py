"""Arithmetic as in Python with bounded results, and filters and functions of numbers. Pure.

Bounds on numbers are checked by :meth:`Run.handle`. A filter with a *default* returns it for a value that is no number,
and fails without one; an undefined value fails with one too.

Source: ``homeassistant/helpers/template.py`` of Home Assistant 2025.4.4.
"""

import math
import operator
from collections.abc import Callable
from typing import Final

from homebot.integrations.homeassistant.formats.jinja.evaluation import Run
from homebot.integrations.homeassistant.formats.jinja.texts import percent
from homebot.integrations.homeassistant.formats.jinja.values import (
    MAX_ITEMS,
    MAX_NUMBER_BITS,
    MAX_NUMERAL,
    MAX_TEXT,
    TemplateError,
    Undefined,
    real,
    text,
    whole,
)

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
    "in": lambda item, many: operator.contains(_container(many), item),
    "notin": lambda item, many: not operator.contains(_container(many), item),
}
"""The comparisons, by Jinja's names of them."""


def _container(many: object) -> list[object] | str | tuple[object, ...] | dict[object, object]:
    if isinstance(many, (str, list, tuple, dict)):
        return many
    if not many and hasattr(many, "__iter__"):
        return ()
    raise TypeError(f"`in` does not work on a {type(many).__name__}")


MISSING: Final = object()
"""Stands for a default that is not given."""

_MAX_DECIMALS = 300
_MAX_FLAG_CHARACTERS = 32
_FLAGS: Final[dict[str | None, bool]] = {
    **dict.fromkeys(("1", "true", "yes", "on", "enable"), True),
    **dict.fromkeys(("0", "false", "no", "off", "disable"), False),
}


def is_number(_: Run, value: object) -> bool:
    """Return whether *value* is a finite number, or the text of one."""
    try:
        return math.isfinite(real(value))
    except (ValueError, TypeError):
        return False


def _or_default(value: object, default: object, name: str, convert: Callable[[], object]) -> object:
    """Return the converted *value*, or the *default* if it cannot be converted."""
    try:
        return convert()
    except (ValueError, TypeError):
        if default is MISSING:
            kind = type(value).__name__
            raise TemplateError(f"{name} is given a {kind} that it cannot convert, and no default") from None
        return default


def _float(_: Run, value: object, default: object = MISSING) -> object:
    return _or_default(value, default, "float", lambda: real(value))


def _int(_: Run, value: object, default: object = MISSING, base: object = 10) -> object:
    if isinstance(value, Undefined):
        value.fail()

    def convert() -> object:
        if isinstance(value, int) and not isinstance(value, bool):
            return value
        if isinstance(value, str) and len(value) <= MAX_NUMERAL:
            try:
                return int(value, whole(base))
            except (ValueError, TypeError):
                pass  # 42.23 gives 42
        number = real(value)
        if isinstance(value, str) and not math.isfinite(number):
            raise ValueError("an infinite number is no whole one")
        return int(number)

    return _or_default(value, default, "int", convert)


def _bool(_: Run, value: object, default: object = MISSING) -> object:
    def convert() -> bool:
        flag = value[:_MAX_FLAG_CHARACTERS].lower().strip() if isinstance(value, str) else None
        if flag in _FLAGS:
            return _FLAGS[flag]
        if isinstance(value, (bool, int, float)):
            return value != 0
        raise TypeError("no flag")

    return _or_default(value, default, "bool", convert)


def _round(
    _: Run, value: object, precision: object = 0, method: object = "common", default: object = MISSING
) -> object:
    places = whole(precision)
    if abs(places) > _MAX_DECIMALS:
        raise TemplateError(f"a number is rounded to more than {_MAX_DECIMALS} places")

    def convert() -> float:
        multiplier, number = float(10**places), real(value)
        match method:
            case "ceil":
                number = math.ceil(number * multiplier) / multiplier
            case "floor":
                number = math.floor(number * multiplier) / multiplier
            case "half":
                number = round(number * 2) / 2
            case _:
                number = round(number, places)
        return int(number) if places == 0 else number

    return _or_default(value, default, "round", convert)


def _with_amount(operate: Callable[[float, float], object], name: str) -> Callable[..., object]:
    def calculate(_: Run, value: object, amount: object, default: object = MISSING) -> object:
        return _or_default(value, default, name, lambda: operate(real(value), _amount(amount)))

    return calculate


def _amount(value: object) -> float:
    if isinstance(value, Undefined):
        value.fail()
    if not isinstance(value, (int, float)):
        raise TypeError(f"a {type(value).__name__} is not a number of seconds or a time difference")
    return value


def _of_number(calculate: Callable[[float], float], name: str) -> Callable[..., object]:
    def filter_(_: Run, value: object, default: object = MISSING) -> object:
        return _or_default(value, default, name, lambda: calculate(real(value)))

    return filter_


def _log(_: Run, value: object, base: object = math.e, default: object = MISSING) -> object:
    return _or_default(value, default, "log", lambda: math.log(real(value), real(base)))


def _abs(_: Run, value: object) -> object:
    if not isinstance(value, (int, float)):
        raise TypeError(f"abs is given a {type(value).__name__}")
    return abs(value)


def _bitwise(operate: Callable[[int, int], int]) -> Callable[..., object]:
    return lambda _, first, second: operate(whole(first), whole(second))


def _average(_: Run, values: object, default: object = MISSING) -> object:
    def convert() -> float:
        if (
            not isinstance(values, (list, tuple))
            or not values
            or not all(isinstance(value, (int, float)) for value in values)
        ):
            raise TypeError("no numbers")
        return math.fsum(values) / len(values)

    return _or_default(values, default, "average", convert)


def _iif(_: Run, value: object, if_true: object = True, if_false: object = False, if_none: object = MISSING) -> object:
    if value is None and if_none is not MISSING:
        return if_none
    return if_true if value else if_false


def _ordinal(_: Run, value: object) -> str:
    shown = text(value)
    tens, ones = int(shown[-2:]) % 100, int(shown[-1]) % 10
    return shown + ("th" if tens in range(11, 14) else {1: "st", 2: "nd", 3: "rd"}.get(ones, "th"))


NUMBER_FUNCTIONS: Final[dict[str, Callable[..., object]]] = {
    **{name: _of_number(getattr(math, name), name) for name in ("acos", "asin", "atan", "cos", "sin", "sqrt", "tan")},
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
    "add": _with_amount(operator.add, "add"),
    "average": _average,
    "bitwise_and": _bitwise(operator.and_),
    "bitwise_or": _bitwise(operator.or_),
    "bitwise_xor": _bitwise(operator.xor),
    "multiply": _with_amount(operator.mul, "multiply"),
    "ordinal": _ordinal,
    "round": _round,
}
"""By name; each takes the run and the value first."""

CONSTANTS: Final[dict[str, float]] = {"e": math.e, "pi": math.pi, "tau": math.tau}
"""Meanings of names that are not defined otherwise."""
