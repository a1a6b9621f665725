"""Text form of states, the same for every convention. Pure.

The texts are those of the thesis's topics: ``on``, ``off``, ``open``, ``closed``, ``motion``, ``clear``, ``locked``, a
brightness or a position from ``0`` to ``1``, ``2700 K``, a measured number.
"""

import math
from collections.abc import Iterator, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import Final, TypeAlias

from homebot.devices.capabilities import CAPABILITIES, OWN, SPEED_WORDS
from homebot.devices.part import Capability, Part
from homebot.devices.value import PlainValue
from homebot.support.numbers import to_number

_UNKNOWN: Final = frozenset({"none", "null", "unknown", "unavailable"})

_MAX_UNKNOWN: Final = 40

OPENING_WORDS: Final = ("movement", "valve")

PRIORITY: Final = ("lock", "on_off", "occupancy", "contact", "vacuum", "mower", "alarm", "local_temperature")
"""The first of these is the text of a message with several values; movements follow, with their own rule."""

Decoded: TypeAlias = Mapping[str, PlainValue]
"""Values by capability."""

_NOTHING: Decoded = MappingProxyType({})

_MAX_BYTES = 255
"""The longest free text, in bytes."""


def encode_state(readings: Mapping[str, PlainValue]) -> str | None:
    """Return the text for the values in one message of a part; None if no value has a text.

    Args:
        readings: Values by capability.
    """
    for name in PRIORITY:
        if readings.get(name) is not None:
            return encode_value(name, readings[name])
    if (opening := _opening(readings)) is not None:
        return opening
    for name, value in readings.items():
        if (text := encode_value(name, value)) is not None:
            return text
    return None


def encode_value(name: str, value: PlainValue) -> str | None:
    """Return the text for one value of the capability *name*; None if there is none."""
    match value:
        case None | tuple():
            return None
        case bool():
            return CAPABILITIES.get(name, OWN).texts[value]
        case str():
            return value
        case _ if is_share(name):
            return _digits(value / 100)
        case _ if name == "color_temperature":
            return f"{_digits(value)} K"
        case _:
            return _digits(value)


class TextDecoder:
    """Decoder of the texts of a part, a look-up table, so that any other payload costs next to nothing.

    It is the inverse of :func:`encode_state`. Implied values are included: with ``0.4`` a lamp is on, with ``closed`` a
    cover is at 0 %. A bare number belongs to the first capability in the order of :func:`encode_state` whose bounds
    contain it. ``nan`` and the like in place of a measurement mean that it is unknown.

    Attributes:
        expects: The texts in words; empty for a part without capabilities.
    """

    def __init__(self, capabilities: tuple[Capability, ...]) -> None:
        names = ", ".join([capability.name for capability in capabilities])
        self.expects = names and f"a state of {names}"
        readable = {capability.name: capability for capability in capabilities if capability.readable}
        self._names = frozenset(readable)
        self._texts: dict[bytes, Decoded] = {}
        self._numbers: list[tuple[str, float, float]] = []
        self._kelvin: tuple[float, float] | None = None
        self._text_capability = ""
        self._measured = ""
        for name in dict.fromkeys(
            (*(preferred for preferred in (*PRIORITY, *OPENING_WORDS) if preferred in readable), *readable)
        ):
            capability = readable[name]
            match CAPABILITIES.get(name, OWN).kind:
                case "bool":
                    for value, text in enumerate(CAPABILITIES.get(name, OWN).texts):
                        self._texts.setdefault(text.encode(), self._values(name, bool(value)))
                case "text":
                    options = capability.options or CAPABILITIES[name].options
                    for option in options:
                        self._texts.setdefault(option.encode(errors="replace"), self._values(name, option))
                    self._text_capability = self._text_capability or ("" if options else name)
                case "number":
                    self._learn_number(name, capability)

    def decode(self, text: bytes) -> Decoded:
        """Return the values in *text*; empty if it is not a text of the part."""
        decoded = self._texts.get(text)
        if decoded is not None:
            return decoded
        if (measured := self._number_in(text)) is not None:
            return measured
        if self._text_capability:
            if not 0 < len(text) <= _MAX_BYTES:
                return _NOTHING
            try:
                return {self._text_capability: text.decode()}
            except UnicodeDecodeError:
                return _NOTHING
        return {self._measured: None} if self._measured and means_unknown(text) else _NOTHING

    def _number_in(self, text: bytes) -> Decoded | None:
        number = to_number(text)
        if number is not None:
            for name, low, high in self._numbers:
                if low <= number <= high:
                    return self._values(name, percent(number) if is_share(name) else number)
        elif self._kelvin is not None and text.endswith(b" K"):
            number = to_number(text[:-2])
            if number is not None and self._kelvin[0] <= number <= self._kelvin[1]:
                return self._values("color_temperature", number)
        return None

    def _learn_number(self, name: str, capability: Capability) -> None:
        low, high = bounds_of(capability)
        if name == "color_temperature":
            self._kelvin = low, high
            return
        share = 100 if is_share(name) else 1
        self._numbers.append((name, low / share, high / share))
        self._measured = self._measured or ("" if capability.settable else name)

    def _values(self, name: str, value: PlainValue) -> Decoded:
        return {name: value, **{other: implied for other, implied in _implied(name, value) if other in self._names}}


@lru_cache(maxsize=1000)
def decoder_for(capabilities: tuple[Capability, ...]) -> TextDecoder:
    """Return the shared decoder of parts with *capabilities*."""
    return TextDecoder(capabilities)


def decode_text(text: str, part: Part) -> Decoded:
    """Return the values in a *text* of *part*; see :class:`TextDecoder`."""
    return decoder_for(part.capabilities).decode(text.encode(errors="replace"))


def bounds_of(capability: Capability) -> tuple[float, float]:
    """Return the smallest and the largest value of *capability*; infinite if unknown."""
    bounds = capability.bounds or CAPABILITIES.get(capability.name, OWN).bounds
    return (bounds[0], bounds[-1]) if bounds else (-math.inf, math.inf)


def means_unknown(text: str | bytes) -> bool:
    """Return whether *text*, in place of a number, means that it is unknown: NaN and the like, or a word."""
    if len(text) > _MAX_UNKNOWN:
        return False
    try:
        return not math.isfinite(float(text))
    except ValueError:
        word = text.decode(errors="replace") if isinstance(text, bytes) else text
        return word.strip().lower() in _UNKNOWN


def is_share(name: str) -> bool:
    """Return whether the capability *name* is a percentage that is 0 to 1 in texts."""
    return CAPABILITIES.get(name, OWN).bare == "share"


def percent(share: float) -> float:
    """Return *share* in percent without rounding errors: 0.07 is 7 %, not 7.000000000000001."""
    return round(share * 100, 9)


def _opening(readings: Mapping[str, PlainValue]) -> str | None:
    """Return the direction while it moves; at rest ``closed``, ``open``, or a position in between."""
    movement = next((readings[name] for name in OPENING_WORDS if readings.get(name) is not None), None)
    position = readings.get("position")
    if movement in {"opening", "closing"} or not isinstance(position, float):
        return movement if isinstance(movement, str) else None
    return {0.0: "closed", 100.0: "open"}.get(position) or _digits(position / 100)


def _digits(value: float) -> str:
    return f"{round(value, 3) + 0.0:.3f}".rstrip("0").rstrip(".")


def _implied(name: str, value: PlainValue) -> Iterator[tuple[str, PlainValue]]:
    if name in SPEED_WORDS and isinstance(value, float):
        yield "on_off", value > 0
    if name == "position" and isinstance(value, float):
        movement = {0.0: "closed", 100.0: "open"}.get(value, "stopped")
        yield from ((word, movement) for word in OPENING_WORDS)
    if name in OPENING_WORDS and value in {"open", "closed"}:
        yield "position", 100.0 if value == "open" else 0.0
