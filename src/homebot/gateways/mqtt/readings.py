"""What a message of a device tells, and the JSON, texts and numbers to read it from. Pure; nothing here raises."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TypeAlias

from homebot.devices.value import PlainValue
from homebot.errors import WireError
from homebot.gateways.mqtt.payload import MAX_STATE_BYTES, parse_json

__all__ = ["NOTHING", "JsonMessage", "Readings", "finite_number", "json_in", "number_in", "text_in"]

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.gateways.mqtt.description.Codec.read`."""

JsonMessage: TypeAlias = Mapping[str, object]
"""One message: a JSON object. Nobody changes it, because all parts that read it share it."""

NOTHING: Readings = MappingProxyType({})


@lru_cache(maxsize=8)
def text_in(payload: bytes) -> str | None:
    """Return the text that *payload* is; None where it is none, or longer than what is looked at."""
    if len(payload) > MAX_STATE_BYTES:
        return None
    try:
        return payload.decode()
    except UnicodeDecodeError:
        return None


@lru_cache(maxsize=2)  # all parts of a device read the same message, one after the other
def json_in(payload: bytes) -> object:
    """Return what *payload* says in JSON, not to be changed; None where that is nothing."""
    try:
        return parse_json(payload)
    except WireError:
        return None


def finite_number(value: object) -> float | None:
    """Return *value* where it is a number of a size that devices have, one of 64 bits; a bool is none."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and -_HUGE < value < _HUGE:
        return float(value)
    return None


def number_in(value: object) -> float | None:
    """Return the number that *value* is as :func:`finite_number` has it, or that a text spells plainly."""
    if not isinstance(value, str):
        return finite_number(value)
    if len(value) > _LONGEST_NUMBER or not value.isascii() or "_" in value:
        return None
    try:
        return finite_number(float(value))
    except ValueError:
        return None


_HUGE = 2.0**64
_LONGEST_NUMBER = 40
