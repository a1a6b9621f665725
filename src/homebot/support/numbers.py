"""Parsing of numbers in untrusted input: one rule for all. Pure; nothing here raises."""

from typing import Final

__all__ = ["finite_number", "to_number", "whole_number"]

_HUGE: Final = 2.0**64
_LONGEST: Final = 40
_UNDERSCORE: Final = ord("_")


def finite_number(value: object) -> float | None:
    """Return *value* where it is a number of a size that devices have, one of 64 bits; a bool is none."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and -_HUGE < value < _HUGE:
        return float(value)
    return None


def whole_number(value: object) -> int | None:
    """Return *value* if it is a whole number, otherwise None; a bool is none."""
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def to_number(value: object) -> float | None:
    """Return the number that *value* is as :func:`finite_number` has it, or that a text or its bytes spell.

    Plain spelling is meant: ASCII of at most 40 characters, no ``1_000``, no ``nan`` or ``inf``.
    """
    if isinstance(value, str):
        is_plain = "_" not in value
    elif isinstance(value, bytes):
        is_plain = _UNDERSCORE not in value  # a byte is found five times sooner than bytes
    else:
        return finite_number(value)
    if not is_plain or len(value) > _LONGEST or not value.isascii():
        return None
    try:
        number = float(value)
    except ValueError:
        return None
    return number if -_HUGE < number < _HUGE else None
