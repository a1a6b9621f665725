"""Values in a text that a template rendered or a device sent, and percentages of a device's own range. Pure.

Source of the rounding: Home Assistant core 2025.4, ``util/scaling.py`` and ``util/percentage.py``.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from homebot.conventions.payload import parse_json
from homebot.errors import WireError
from homebot.numbers import to_number

__all__ = ["Scale", "fields_of", "number_of", "numbers_of", "whole_of"]


def number_of(value: object) -> float | None:
    """Return the number that a text or a JSON value is; None where it is none. As in Python, true is 1."""
    return float(value) if isinstance(value, bool) else to_number(value)


def whole_of(text: str) -> int | None:
    """Return the whole number that *text* is, without point or exponent; None where it is none."""
    try:
        return int(text) if len(text) <= _MAX_DIGITS else None
    except ValueError:
        return None


def numbers_of(text: str, count: int) -> tuple[float, ...] | None:
    """Return the *count* numbers that *text* has between commas; None where it has others."""
    parts = text.split(",", count)
    numbers = [number for part in parts if (number := number_of(part)) is not None]
    return tuple(numbers) if len(numbers) == len(parts) == count else None


def fields_of(text: str) -> Mapping[str, object]:
    """Return the JSON object that *text* is; empty where it is none."""
    if not text.lstrip().startswith("{"):
        return _NO_FIELDS
    try:
        message = parse_json(text)
    except WireError:
        return _NO_FIELDS
    return message if isinstance(message, dict) else _NO_FIELDS


_NO_FIELDS: Mapping[str, object] = MappingProxyType({})
_MAX_DIGITS = 40


@dataclass(frozen=True, slots=True)
class Scale:
    """Two values of a device that stand for 0 % and 100 %; the first may be the larger one.

    Raises:
        WireError: Both are the same.
    """

    zero: int
    full: int

    def __post_init__(self) -> None:
        if self.zero == self.full:
            raise WireError(f"0 % and 100 % are the same value, {self.zero}")

    def percent(self, value: float) -> float:
        """Return *value* in whole percent, rounded towards the zero; outside of 0 to 100 where the value is outside."""
        value = min(max(value, -_FAR), _FAR)
        return float((value - self.zero) * 100 // (self.full - self.zero))

    def value(self, percent: float) -> float:
        """Return the exact value that stands for *percent*."""
        return percent * (self.full - self.zero) / 100 + self.zero


_FAR = 1e100
"""Beyond any device's values, and still a number after multiplication."""
