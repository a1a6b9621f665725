"""Settings from the words of a command, such as ``on`` with ``level`` 40, for one part. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import Final

from homebot.devices import KeyValue
from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.devices.setting_check import accepted_values, check_setting
from homebot.devices.text.commands import decode_command
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.numbers import to_number

__all__ = ["SET", "spoken_settings"]

SET: Final = "set"
"""The command that sets values and nothing else."""

_ALIASES: Final[Mapping[str, str]] = MappingProxyType(
    {"kelvin": "color_temperature", "brightness": "level", "speed": "fan_speed", "mode": "thermostat_mode"}
)
_SAME_WORDS: Final[Mapping[str, str]] = MappingProxyType({"turn_on": "on", "turn_off": "off"})
_FLAGS: Final[Mapping[str, bool]] = MappingProxyType(
    {"on": True, "true": True, "yes": True, "1": True, "off": False, "false": False, "no": False, "0": False}
)
_NUMBER: Final = re.compile(r"([+-]?[\d.]+)\s*(\S*)")


def spoken_settings(command: str, values: Iterable[KeyValue], part: Part, target: str) -> dict[str, PlainValue]:
    """Return the values by capability that a command sets at *part*.

    Args:
        command: A word that the part takes, such as ``on``, ``close``, ``0.4`` or ``2700 K``; :data:`SET` for none.
        values: Further values by capability, as text: ``level`` is ``40``.
        part: The part.
        target: Its name, for errors.

    Raises:
        RefusedError: It takes no such word, capability or value, or there is none; the message names those that it
            takes.
    """
    word = command.strip()
    word = _SAME_WORDS.get(word, word)
    found: dict[str, PlainValue] = {}
    given = [(_ALIASES.get(one.key, one.key), one.value) for one in values]
    if word != SET and not (word == "on" and given and part.service_type == "light"):  # a level turns a lamp on
        capability, value = _decoded(word, part)
        found[capability] = value
    for name, text in given:
        found[name] = _value(name, text, part, target)
    for name, value in found.items():
        check_setting(target, part, name, value)
    if not found:
        raise RefusedError(f"{SET} without values", "give one, such as level 40")
    return found


def _decoded(word: str, part: Part) -> tuple[str, PlainValue]:
    try:
        return decode_command(word, part)
    except RefusedError:
        accepted = accepted_values(part, _ALIASES.get(word, word))
        if not accepted:
            raise
        raise RefusedError(f"{word} without a value", f"it takes {accepted}") from None


def _value(name: str, text: str, part: Part, target: str) -> PlainValue:
    known = CAPABILITIES.get(name)
    kind = "text" if known is None else known.kind
    plain = text.strip()
    if kind == "bool":
        flag = _FLAGS.get(plain.casefold())
        if flag is None:
            raise RefusedError(f"{plain[:40]!r} as {name} of {target}", "it takes on or off")
        return flag
    if kind == "number":
        return _number(name, plain, part, target)
    if kind == "numbers":
        return tuple(_number(name, one.strip(), part, target) for one in plain.split(","))
    return plain


def _number(name: str, text: str, part: Part, target: str) -> float:
    match = _NUMBER.fullmatch(text)
    number = None if match is None else to_number(match[1])
    unit = _unit(name, part.capabilities)
    if match is None or number is None or match[2] not in {"", unit}:
        accepted = f"it takes a number in {unit}" if unit else "it takes a number"
        raise RefusedError(f"{text[:40]!r} as {name} of {target}", accepted)
    return number


def _unit(name: str, capabilities: Iterable[Capability]) -> str:
    own = next((one.unit for one in capabilities if one.name == name and one.unit), "")
    return own or (CAPABILITIES[name].unit if name in CAPABILITIES else "")
