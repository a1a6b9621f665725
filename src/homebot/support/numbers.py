"""Parsing of numbers in untrusted input. Pure; never raises."""

from typing import Final

_HUGE: Final = 2.0**64
_MAX_CHARACTERS: Final = 40
_UNDERSCORE: Final = ord("_")


def finite_number(value: object) -> float | None:
    """Return *value* if it is a number of at most 64 bits, otherwise None; a bool is not a number."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and -_HUGE < value < _HUGE:
        return float(value)
    return None


def whole_number(value: object) -> int | None:
    """Return *value* if it is an integer, otherwise None; a bool is not."""
    return value if isinstance(value, int) and not isinstance(value, bool) else None


def to_number(value: object) -> float | None:
    """Return *value* as a number by :func:`finite_number`, or the number in a text or bytes.

    Texts must be plain: ASCII, at most 40 characters, no ``1_000``, ``nan`` or ``inf``.
    """
    if isinstance(value, str):
        is_plain = "_" not in value
    elif isinstance(value, bytes):
        is_plain = _UNDERSCORE not in value  # a byte is found five times sooner than bytes
    else:
        return finite_number(value)
    if not is_plain or len(value) > _MAX_CHARACTERS or not value.isascii():
        return None
    try:
        number = float(value)
    except ValueError:
        return None
    return number if -_HUGE < number < _HUGE else None
