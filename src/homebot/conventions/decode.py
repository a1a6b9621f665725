"""Readings of a message, and the JSON and texts to take them from. Pure; nothing here raises."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TypeAlias

from homebot.conventions.payload import MAX_STATE_BYTES, parse_json
from homebot.devices.text.vocabulary import says_unknown
from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.numbers import to_number

__all__ = [
    "NO_READINGS",
    "JsonMessage",
    "Readings",
    "is_unknown",
    "read_number",
    "to_json",
    "to_text",
]

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.conventions.description.Codec.read`."""

JsonMessage: TypeAlias = Mapping[str, object]
"""One message: a JSON object. Nobody changes it, because all parts that read it share it."""

NO_READINGS: Readings = MappingProxyType({})


@lru_cache(maxsize=8)
def to_text(payload: bytes) -> str | None:
    """Return the text that *payload* is; None where it is none, or longer than what is looked at."""
    if len(payload) > MAX_STATE_BYTES:
        return None
    try:
        return payload.decode()
    except UnicodeDecodeError:
        return None


@lru_cache(maxsize=2)  # all parts of a device read the same message, one after the other
def to_json(payload: bytes) -> object:
    """Return what *payload* says in JSON, not to be changed; None where that is nothing."""
    try:
        return parse_json(payload)
    except WireError:
        return None


def is_unknown(value: object) -> bool:
    """Tell whether *value*, in the place of a number, says that the device does not know it.

    That is null, a number that is none or has no end, and the words that firmware has for these.
    """
    if isinstance(value, str):
        return says_unknown(value)
    return value is None or (isinstance(value, float) and not math.isfinite(value))


def read_number(capability: str, value: object, convert: Callable[[float], float | None] = float) -> Readings:
    """Return what *value* tells of *capability*: a number, that it is unknown, or nothing.

    Args:
        capability: What the number is.
        value: What the message has in its place.
        convert: Makes the value of the number; None where that cannot be.
    """
    number = to_number(value)
    if number is None:
        return {capability: None} if is_unknown(value) else NO_READINGS
    outside = convert(number)
    return NO_READINGS if outside is None else {capability: outside}
