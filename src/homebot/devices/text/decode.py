"""Decodes what a device publishes as text, the reverse of :func:`homebot.devices.text.encode.encode_state`. Pure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TypeAlias

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.part import Capability, Part
from homebot.devices.text.vocabulary import (
    BOOL_WORDS,
    FRACTION_CAPABILITIES,
    OPENING_WORDS,
    PRIORITY,
    SPEED_WORDS,
    bounds_of,
    percent,
    says_unknown,
)
from homebot.devices.value import PlainValue
from homebot.numbers import to_number

__all__ = ["Decoded", "TextDecoder", "decode_text", "decoder_for"]

Decoded: TypeAlias = Mapping[str, PlainValue]
"""What a word tells, by capability."""

_NOTHING: Decoded = MappingProxyType({})

_LONGEST = 255
"""Bytes of a word that may be any text."""


class TextDecoder:
    """The words of a part, ready to be looked up, so that a payload which is none of them costs next to nothing.

    What follows from a word is heard as well: a lamp that says ``0.4`` is on, and what says ``closed`` is at 0 %. Of
    several capabilities that a bare number may be about it is the one that
    :func:`homebot.devices.text.encode.encode_state` speaks of first, among those whose bounds it keeps. What says
    ``nan`` where it should say what it measures does not know it.

    Args:
        capabilities: What the part can be asked and told.
    """

    def __init__(self, capabilities: tuple[Capability, ...]) -> None:
        readable = {one.name: one for one in capabilities if one.readable}
        self._names = frozenset(readable)
        self._words: dict[bytes, Decoded] = {}
        self._numbers: list[tuple[str, float, float]] = []
        self._kelvin: tuple[float, float] | None = None
        self._text = ""
        self._measured = ""
        for name in dict.fromkeys((*(one for one in (*PRIORITY, *OPENING_WORDS) if one in readable), *readable)):
            self._learn(name, readable[name])

    def decode(self, said: bytes) -> Decoded:
        """Return what *said* tells of the part; nothing where it is none of its words."""
        found = self._words.get(said)
        if found is not None:
            return found
        number = to_number(said)
        if number is not None:
            for name, low, high in self._numbers:
                if low <= number <= high:
                    return self._told(name, percent(number) if name in FRACTION_CAPABILITIES else number)
        elif self._kelvin is not None and said.endswith(b" K"):
            number = to_number(said[:-2])
            if number is not None and self._kelvin[0] <= number <= self._kelvin[1]:
                return self._told("color_temperature", number)
        if self._text:
            return self._as_text(said)
        return {self._measured: None} if self._measured and says_unknown(said) else _NOTHING

    def _learn(self, name: str, capability: Capability) -> None:
        known = CAPABILITIES.get(name)
        kind = known.kind if known else ""
        if kind == "bool":
            for value, said in enumerate(BOOL_WORDS.get(name, ("off", "on"))):
                self._words.setdefault(said.encode(), self._told(name, bool(value)))
        elif kind == "text":
            options = capability.options or (known.options if known else ())
            for said in options:
                self._words.setdefault(said.encode(errors="replace"), self._told(name, said))
            self._text = self._text or ("" if options else name)
        elif kind == "number":
            low, high = bounds_of(capability)
            if name == "color_temperature":
                self._kelvin = low, high
            else:
                share = 100 if name in FRACTION_CAPABILITIES else 1
                self._numbers.append((name, low / share, high / share))
                self._measured = self._measured or ("" if capability.settable else name)

    def _told(self, name: str, value: PlainValue) -> Decoded:
        return {name: value, **{other: what for other, what in _implied(name, value) if other in self._names}}

    def _as_text(self, said: bytes) -> Decoded:
        if not 0 < len(said) <= _LONGEST:
            return _NOTHING
        try:
            return {self._text: said.decode()}
        except UnicodeDecodeError:
            return _NOTHING


@lru_cache(maxsize=1000)
def decoder_for(capabilities: tuple[Capability, ...]) -> TextDecoder:
    """Return the ear for parts with *capabilities*; they share it."""
    return TextDecoder(capabilities)


def decode_text(said: str, part: Part) -> Decoded:
    """Return what the word *said* tells of *part*; see :class:`TextDecoder`."""
    return decoder_for(part.capabilities).decode(said.encode(errors="replace"))


def _implied(name: str, value: PlainValue) -> Iterator[tuple[str, PlainValue]]:
    if name in SPEED_WORDS and isinstance(value, float):
        yield "on_off", value > 0
    if name == "position" and isinstance(value, float):
        movement = {0.0: "closed", 100.0: "open"}.get(value, "stopped")
        yield from ((one, movement) for one in OPENING_WORDS)
    if name in OPENING_WORDS and value in {"open", "closed"}:
        yield "position", 100.0 if value == "open" else 0.0
