"""Values in words, for people. Pure."""

from __future__ import annotations

from typing import Final

from homebot.devices.value import PlainValue

__all__ = ["value_text"]

_LONGEST: Final = 40


def value_text(value: PlainValue) -> str:
    """Return *value* in words, of 40 characters at most: ``on``, ``21.5``, ``open``."""
    match value:
        case bool():
            return "on" if value else "off"
        case float():
            return _number_text(value)
        case tuple():
            return ", ".join(map(_number_text, value))
        case None:
            return "unknown"
    return value[:_LONGEST]


def _number_text(value: float) -> str:
    """Return a number with two decimals at most: 89 of 255 steps are 34.9 %, and not 34.902."""
    return f"{round(value, 2):g}"
