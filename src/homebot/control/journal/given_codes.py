"""Codes and passwords in commands: the journal records that one was given, but not its value. Pure."""

import re
from functools import lru_cache
from operator import attrgetter
from typing import Final

from homebot.conventions.secrets import names_secret
from homebot.devices import Device, DevicePart
from homebot.devices.command_messages import Setting
from homebot.devices.value import Value

CODE_GIVEN: Final = "a code"
"""Replaces the value of a code."""

UNREAD: Final = "raw_text"
"""The capability of a text with an unknown effect; only the verb ``use`` matches it."""

_MAY_BE_CODE: Final = frozenset({"number", "text", UNREAD})
"""The capabilities whose values may be codes."""

_FIELD: Final = re.compile(r'"(?P<key>[^"\\]{1,80})"(?P<colon>\s*:\s*)(?:"(?:[^"\\]|\\.)*"|[^\s",{}\[\]]+)')
"""A field of JSON with a text or a number."""

_ENDS: Final = ("code", "password", "token", "_pin", "-pin", " pin")
_CAPABILITY: Final = attrgetter("capability")
_MAX_READ_CHARACTERS: Final = 5_000
"""The limit of characters of a raw text that are searched for codes."""

MAX_NOTED_CHARACTERS: Final = 500
"""The limit of characters of a raw text in the journal."""


def without_codes(settings: tuple[Setting, ...], device: Device | None, part: DevicePart | None) -> tuple[Setting, ...]:
    """Return the *settings* for *part* of *device*, with :data:`CODE_GIVEN` in place of each code, judging by names.

    If the part is unknown and any setting may be a code, none is returned. If it is only a stand-in, all parts count.
    """
    if _MAY_BE_CODE.isdisjoint(map(_CAPABILITY, settings)):
        return settings
    if device is None or part is None:
        return () if part is None else settings
    parts = device.parts if device.part(part.id) is None else (part,)
    names = (name for part in parts for name in (part.part.name or device.name, part.part.id, part.part.advertised))
    if not any(map(names_secret, names)):
        return settings
    given = Value.of(CODE_GIVEN)
    return tuple(
        setting.model_copy(update={"value": given}) if setting.capability in _MAY_BE_CODE else setting
        for setting in settings
    )


@lru_cache(maxsize=1024)
def is_for_code(address: str) -> bool:
    """Return whether *address* is named like a code."""
    return names_secret(address)


def public_text(text: str, address: str) -> str:
    """Return the raw *text* of a command to *address* with ``"***"`` in place of each code, or :data:`CODE_GIVEN`."""
    if is_for_code(address):
        return CODE_GIVEN
    known = text[:_MAX_READ_CHARACTERS]
    public = _FIELD.sub(_without_code, known)
    return CODE_GIVEN if public == known and names_secret(public) else public


def _without_code(field: re.Match[str]) -> str:
    key = field["key"].lower()
    if key.endswith(_ENDS) or key == "pin" or names_secret(key):
        return f'"{field["key"]}"{field["colon"]}"***"'
    return field[0]
