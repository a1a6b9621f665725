"""The values a template handles: look-up and text of each, in bounded work."""

from __future__ import annotations

from collections.abc import Iterator
from datetime import datetime
from typing import NoReturn, final

from homebot.conventions.jinja.limits import MAX_ITEMS, MAX_NUMERAL, MAX_TEXT, TemplateError, UndefinedValueError

__all__ = ["UNDEFINED", "Namespace", "Undefined", "item", "real", "text", "weigh", "whole"]


class Undefined:
    """The value of a name, a key or an index that has none.

    It is false, empty and equal to its like, and its text is empty. Arithmetic, order, and looking into it raise
    :class:`UndefinedValueError`.

    Source: Jinja 3.1 documentation, Undefined Types, ``Undefined``.
    """

    __slots__ = ()

    def __str__(self) -> str:
        return ""

    def __repr__(self) -> str:
        return "Undefined"

    def __bool__(self) -> bool:
        return False

    def __len__(self) -> int:
        return 0

    def __iter__(self) -> Iterator[object]:
        return iter(())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Undefined)

    def __hash__(self) -> int:
        return id(Undefined)

    def fail(self, *_: object) -> NoReturn:
        """Raise the error of every use of the value."""
        raise UndefinedValueError("a value that the template uses is not in the message")

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = fail
    __floordiv__ = __rfloordiv__ = __mod__ = __rmod__ = __pow__ = __rpow__ = __neg__ = __pos__ = fail
    __getitem__ = __lt__ = __le__ = __gt__ = __ge__ = __int__ = __float__ = fail


UNDEFINED = Undefined()


@final
class Namespace:
    """The result of ``namespace()``: the one value that a template may change."""

    __slots__ = ("attributes",)

    def __init__(self, attributes: dict[str, object]) -> None:
        self.attributes = attributes

    def __repr__(self) -> str:
        return "<Namespace>"


def item(value: object, key: object) -> object:
    """Return the value at *key* in *value*: a key, an index, or a part of a time; UNDEFINED if there is none.

    Jinja would go on to look for an attribute of that name. We do not: a field missing in a message is undefined.

    Raises:
        TemplateError: *value* is undefined itself.
    """
    if isinstance(value, Undefined):
        value.fail()
    try:
        if isinstance(value, dict):
            return value[key]
        if isinstance(value, (list, tuple, str, bytes)) and isinstance(key, int):
            return value[key]
        if isinstance(value, Namespace) and isinstance(key, str):
            return value.attributes[key]
        if isinstance(value, datetime) and isinstance(key, str) and key in _TIME_PARTS:
            return getattr(value, key)
    except (TypeError, LookupError):
        pass
    return UNDEFINED


def text(value: object) -> str:
    """Return the text of *value*, as Python has it.

    Raises:
        TemplateError: It is too long.
    """
    if isinstance(value, str):
        return value
    if isinstance(value, (dict, list, tuple)):
        weigh(value)
    return str(value)


def weigh(value: object) -> int:
    """Return how many values *value* is made of, itself counted, with one more for every 256 characters.

    Raises:
        TemplateError: There are more than a template may handle.
    """
    waiting = [value]
    count = characters = 0
    while waiting:
        one = waiting.pop()
        count += 1
        if isinstance(one, (str, bytes)):
            characters += len(one)
        elif isinstance(one, (dict, list, tuple)):
            if count + len(waiting) + len(one) > MAX_ITEMS:
                raise TemplateError(f"a list or mapping has more than {MAX_ITEMS} values")
            if isinstance(one, dict):
                waiting.extend(one.keys())
                waiting.extend(one.values())
            else:
                waiting.extend(one)
    if characters > MAX_TEXT:
        raise TemplateError(f"a text has more than {MAX_TEXT} characters")
    return count + characters // 256


def real(value: object) -> float:
    """Return ``float(value)``.

    Raises:
        TypeError: *value* has no number.
        ValueError: Its text is none.
        TemplateError: It is undefined.
    """
    if isinstance(value, Undefined):
        value.fail()
    if isinstance(value, str):
        if len(value) > MAX_NUMERAL:
            raise ValueError(f"a text of {len(value)} characters is no number")
    elif not isinstance(value, (int, float)):
        raise TypeError(f"a {type(value).__name__} is no number")
    return float(value)


def whole(value: object) -> int:
    """Return *value*, which must be a whole number already.

    Raises:
        TypeError: It is none.
        TemplateError: It is undefined.
    """
    if isinstance(value, Undefined):
        value.fail()
    if not isinstance(value, int):
        raise TypeError(f"a {type(value).__name__} is not a whole number")
    return value


_TIME_PARTS = frozenset({"year", "month", "day", "hour", "minute", "second", "microsecond"})
