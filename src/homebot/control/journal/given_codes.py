"""Codes and passwords in commands: the journal has that one was given, and not which. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Final

from homebot.conventions.secrets import names_secret
from homebot.devices import Device, DevicePart
from homebot.devices.command_messages import Setting
from homebot.devices.part import Part
from homebot.devices.value import Value

__all__ = ["CODE_GIVEN", "may_be_code", "public_text", "without_codes"]

CODE_GIVEN: Final = "a code"
"""Stands for the code, in the place of its value."""

_CAPABILITIES: Final = frozenset({"number", "text"})
_FIELD: Final = re.compile(
    r'(?P<key>"(?:[^"]*[_\W])?(?:\w*code|pin|password|token)"\s*:\s*)(?:"(?:[^"\\]|\\.)*"|[^\s",{}\[\]]+)',
    re.IGNORECASE,
)
"""A field of JSON whose name says that it holds a code, with a text or a number."""


def may_be_code(settings: Iterable[Setting]) -> bool:
    """Return whether *settings* can have a code, whatever the part is called."""
    return any(one.capability in _CAPABILITIES for one in settings)


def without_codes(settings: tuple[Setting, ...], device: Device, part: DevicePart) -> tuple[Setting, ...]:
    """Return *settings*, which are for *part* of *device*, with :data:`CODE_GIVEN` for each code."""
    if not may_be_code(settings) or not _takes_code(device, part.part):
        return settings
    given = Value.of(CODE_GIVEN)
    return tuple(one.with_checked(value=given) if one.capability in _CAPABILITIES else one for one in settings)


def public_text(text: str, address: str) -> str:
    """Return the raw *text* of a command to *address* with ``"***"`` for each code in a field, or without all of it."""
    if names_secret(address):
        return CODE_GIVEN
    found, count = _FIELD.subn(r'\g<key>"***"', text)
    return CODE_GIVEN if names_secret(found) and not count else found


def _takes_code(device: Device, part: Part) -> bool:
    """Return whether a text or number for *part* is a code, by any of its names."""
    names = (part.name or device.name, part.id, part.advertised)
    return any(map(names_secret, names))
