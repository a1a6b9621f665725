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
            return f"{value:g}"
        case tuple():
            return ", ".join(f"{one:g}" for one in value)
        case None:
            return "unknown"
    return value[:_LONGEST]
