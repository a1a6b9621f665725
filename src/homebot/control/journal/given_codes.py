"""Codes and passwords in commands: the journal has that one was given, and not which. Pure."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Final

from homebot.conventions.secrets import names_secret
from homebot.devices import Device, DevicePart
from homebot.devices.command_messages import Setting
from homebot.devices.part import Part
from homebot.devices.value import Value

__all__ = ["CODE_GIVEN", "MAY_BE_CODE", "is_for_code", "public_text", "without_codes"]

CODE_GIVEN: Final = "a code"
"""Stands for the code, in the place of its value."""

MAY_BE_CODE: Final = frozenset({"number", "text"})
"""The capabilities whose value can be a code; no other is looked at."""

_FIELD: Final = re.compile(
    r'(?P<key>"(?:[^"]*[_\W])?(?:\w*code|pin|password|token)"\s*:\s*)(?:"(?:[^"\\]|\\.)*"|[^\s",{}\[\]]+)',
    re.IGNORECASE,
)
"""A field of JSON whose name says that it holds a code, with a text or a number."""


def without_codes(settings: tuple[Setting, ...], device: Device, part: DevicePart) -> tuple[Setting, ...]:
    """Return *settings*, which are for *part* of *device*, with :data:`CODE_GIVEN` for each code."""
    if MAY_BE_CODE.isdisjoint(one.capability for one in settings) or not _takes_code(device, part.part):
        return settings
    given = Value.of(CODE_GIVEN)
    return tuple(one.with_checked(value=given) if one.capability in MAY_BE_CODE else one for one in settings)


@lru_cache(maxsize=1024)
def is_for_code(address: str) -> bool:
    """Return whether what is sent to *address* is a code, by the name."""
    return names_secret(address)


def public_text(text: str, address: str) -> str:
    """Return the raw *text* of a command to *address* with ``"***"`` for each code in a field, or without all of it."""
    if is_for_code(address):
        return CODE_GIVEN
    found, count = _FIELD.subn(r'\g<key>"***"', text)
    return CODE_GIVEN if names_secret(found) and not count else found


def _takes_code(device: Device, part: Part) -> bool:
    """Return whether a text or number for *part* is a code, by any of its names."""
    names = (part.name or device.name, part.id, part.advertised)
    return any(map(names_secret, names))
