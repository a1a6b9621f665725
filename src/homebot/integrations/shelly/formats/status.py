"""Readers of a status of a Shelly, an object in JSON. Pure."""

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Final, TypeAlias

from homebot.conventions.payload import NO_READINGS, Readings, as_fields, read_number, text_of, unreadable
from homebot.devices.capabilities import CAPABILITIES

Fields: TypeAlias = Mapping[str, object]
"""A status or a configuration, or a part of one."""

StatusDecoder: TypeAlias = Callable[[Fields], Readings]
"""Reads a status, or the changed fields of one. Never raises."""

MAX_TEXT_CHARACTERS: Final = 255
"""Characters of a text that is read or set."""

_MAX_OPTIONS: Final = 100

NO_FIELDS: Final[Fields] = MappingProxyType({})
"""Stands for a missing value."""


def reader_of(path: str, capability: str, factor: float = 1.0) -> StatusDecoder:
    """Return a reader of the value at *path*, such as ``aenergy.total``; ``null`` is *unknown*.

    The vocabulary says whether it is a number, which is multiplied by *factor*, a boolean or a text.
    """
    kind = CAPABILITIES[capability].kind

    def decode(status: Fields) -> Readings:
        value = value_at(status, path)
        if value is NO_FIELDS:
            return NO_READINGS
        if kind == "number":
            return read_number(capability, value, lambda number: number * factor)
        if value is None or (kind == "bool" and isinstance(value, bool)):
            return {capability: value}
        if kind == "text" and isinstance(value, str):
            return {capability: text_of(value, MAX_TEXT_CHARACTERS)}
        return unreadable(value, "true or false" if kind == "bool" else "a text")

    return decode


def texts_of(listed: object) -> tuple[str, ...]:
    """Return the options that *listed* has."""
    options = listed[:_MAX_OPTIONS] if isinstance(listed, list) else ()
    return tuple(option for option in options if isinstance(option, str) and len(option) <= MAX_TEXT_CHARACTERS)


def value_at(status: Fields, path: str) -> object:
    """Return the value at *path*; ``NO_FIELDS`` if it is missing."""
    *parents, field = path.split(".")
    for parent in parents:
        status = as_fields(status.get(parent))
    return status.get(field, NO_FIELDS)
