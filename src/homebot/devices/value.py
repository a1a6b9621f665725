"""Value of a capability in a report or command, and a reading with its part and capability."""

from __future__ import annotations

from functools import lru_cache
from typing import Annotated, Literal, TypeAlias

from pydantic import Field, model_serializer, model_validator

from homebot.messages.message import Message, UInt8

ShortText: TypeAlias = Annotated[str, Field(max_length=1000)]
"""An id, or the name of a capability, in a request; limited because programs may send many."""

PlainValue: TypeAlias = bool | float | str | tuple[float, ...] | None
"""A value in plain Python; None means *unknown*, which is also a value. Numbers are always ``float``."""

SetBy: TypeAlias = Literal["", "person", "program"]
"""Who set a value past homebot; empty if that is not known."""

_DIGITS = 15
"""Decimal digits that a float always preserves: a level of 0.55 is 55 %, not 55.00000000000001 %."""

_WHOLE = 1e15
"""Numbers from here on have no fraction within these digits."""

_UNKNOWN, _BOOL, _NUMBER, _TEXT, _NUMBERS = range(5)


class Value(Message):
    """One value, a :class:`PlainValue` in Python and in JSON, where its fields are accepted too.

    Attributes:
        type: 0 unknown, 1 bool, 2 number, 3 text, 4 numbers; the field of that type holds the value.
        numbers: The value if it is several numbers, such as hue and saturation.
    """

    type: Annotated[UInt8, Field(le=_NUMBERS)] = _UNKNOWN
    flag: bool = False
    number: float = 0.0
    text: Annotated[str, Field(max_length=16_384)] = ""
    numbers: Annotated[tuple[float, ...], Field(max_length=1000)] = ()

    @model_validator(mode="before")
    @classmethod
    def _read_plain(cls, value: object) -> object:
        match value:
            case None:
                return {}
            case bool():
                return {"type": _BOOL, "flag": value}
            case int() | float():
                return {"type": _NUMBER, "number": value}
            case str():
                return {"type": _TEXT, "text": value}
            case list() | tuple():
                return {"type": _NUMBERS, "numbers": tuple(value)}
        return value

    @model_serializer(mode="plain", when_used="json")
    def json_form(self) -> PlainValue:
        """Return the plain value."""
        return self.plain()

    @classmethod
    def of(cls, plain: PlainValue) -> Value:
        """Return the message that carries *plain*."""
        if isinstance(plain, float):  # by far the most common
            return _of_number(plain)
        match plain:
            case None:
                return UNKNOWN
            case bool():
                return _TRUE if plain else _FALSE
            case str():
                return cls.of_checked(type=_TEXT, flag=False, number=0.0, text=plain, numbers=())
            case tuple():
                return cls(type=_NUMBERS, numbers=tuple(map(_decimal, plain)))
        return _of_number(float(plain))

    def plain(self) -> PlainValue:
        """Return the value in plain Python."""
        match self.type:
            case 2:
                return self.number
            case 1:
                return self.flag
            case 3:
                return self.text
            case 4:
                return self.numbers
            case _:
                return None


class Reading(Message):
    """One value of one part."""

    part: str
    capability: str
    value: Value


@lru_cache(maxsize=10_000)
def _of_number(number: float) -> Value:
    """Return the message that carries *number*; cached, because devices report the same numbers again and again."""
    number = _decimal(number) + 0.0  # no negative zero, which is equal but displayed differently
    return Value.of_checked(type=_NUMBER, flag=False, number=number, text="", numbers=())


def _decimal(number: float) -> float:
    """Return *number* as the decimal number that the device meant, without rounding errors."""
    return float(f"{number:.{_DIGITS}g}") if -_WHOLE < number < _WHOLE else number


UNKNOWN = Value()
_TRUE = Value(type=_BOOL, flag=True)
_FALSE = Value(type=_BOOL, flag=False)


def plain_value(value: PlainValue) -> PlainValue:
    """Return *value* with every number as a ``float``, as in the vocabulary."""
    return float(value) if isinstance(value, int | float) and not isinstance(value, bool) else value
