"""Values of the house, such as ``temperature of office``: in messages of routines, and compared. Pure."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Literal

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.query.terms import And, Query
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.words.phrases import NAMES, TWO_VALUES
from homebot.words.queries import parse_query
from homebot.words.tokens import split_at
from homebot.words.vocabulary import CAPABILITY_WORDS

_PLACE: Final = re.compile(r"\{([^{}]*)\}")
_EXAMPLE: Final = "write it like {temperature of office}, {names of open windows}, {name}, {room}, {routine} or {time}"

_ANY: Final = And(())

_MAX_CAPABILITY_WORDS: Final = max(len(words.split()) for words in CAPABILITY_WORDS)


@dataclass(frozen=True, slots=True)
class MessageValue:
    """A value that is known when the message is sent.

    Attributes:
        kind: ``name`` and ``room`` of the first device that matches *words*, or without them of that which started the
            routine, ``routine`` for its own name, ``time`` for the time of day, ``value`` of the first device, or
            ``names`` of all that match, with this value of each if there is one.
        words: The query as text, in which names of devices count.
    """

    text: str
    kind: Literal["name", "room", "routine", "time", "value", "names"]
    query: Query = _ANY
    capability: str = ""
    words: str = ""


@dataclass(frozen=True, slots=True)
class Comparison:
    """A value is above or below another one, plus *offset*; it does not hold while one is unknown."""

    first: MessageValue
    is_above: bool
    second: MessageValue
    offset: float = 0.0
    is_denied: bool = False


def read_message(text: str) -> tuple[str | MessageValue, ...]:
    """Return *text* in pieces: as it is, and the values in braces; empty if it has no values.

    Raises:
        UsageError: A value in braces is none.
    """
    pieces = _PLACE.split(text)
    return tuple(read_value(piece) if place % 2 else piece for place, piece in enumerate(pieces) if len(pieces) > 1)


def with_values(text: str, change: Callable[[str], str]) -> str:
    """Return *text* with each value in braces as *change* returns it."""
    return _PLACE.sub(lambda place: f"{{{change(place[1])}}}", text)


def read_value(text: str) -> MessageValue:
    """Return the value *text*, such as ``temperature of office``.

    Raises:
        UsageError: It is none.
    """
    plain = " ".join(text.split())
    match plain.casefold():
        case ("name" | "room" | "routine" | "time") as kind:
            return MessageValue(plain, kind)
    for word in ("of", "in"):
        first, *rest = split_at(plain, word)
        if rest and (listed := NAMES.match(f"{first} of")) is not None:
            words, told = plain[len(first) + len(" of ") :], listed.get("capability", "")
            if told and fold(told) not in CAPABILITY_WORDS:
                raise UsageError(
                    f"{{{text}}}: {told!r} is no value; write it like {{names with battery of battery<20}}"
                )
            return MessageValue(plain, "names", parse_query(words), CAPABILITY_WORDS.get(fold(told), ""), words)
        capability = CAPABILITY_WORDS.get(fold(first), "")
        words = plain[len(first) + len(word) + 1 :].strip()
        match fold(first):
            case ("name" | "room") as kind if rest and word == "of":
                return MessageValue(plain, kind, parse_query(words), words=words)
        if rest and capability:
            words = f"in {words}" if word == "in" else words
            return MessageValue(plain, "value", parse_query(words), capability, words)
    words, capability = split_capability(plain)
    if not capability:
        raise UsageError(f"{{{text}}} is no value; {_EXAMPLE}")
    return MessageValue(plain, "value", parse_query(words), capability, words)


def read_comparison(text: str) -> Comparison | None:
    """Return the condition ``temperature of office above temperature of hall plus 2``; None if it is none."""
    if (found := TWO_VALUES.match(text)) is None:
        return None
    values = []
    for words in (found["first"], found["second"]):
        try:
            value = read_value(words) if " of " in words else None
        except UsageError:
            return None
        if value is None or CAPABILITIES.get(value.capability, OWN).kind != "number":
            return None
        values.append(value)
    offset = float(found.get("offset") or 0.0) * (-1.0 if found.get("change") == "minus" else 1.0)
    return Comparison(values[0], found["sign"] in {"above", "over"}, values[1], offset)


def split_capability(text: str) -> tuple[str, str]:
    """Return the words for devices in *text*, and the capability of the words at its end; empty if these are none."""
    words = text.split(" ")
    for place in range(max(1, len(words) - _MAX_CAPABILITY_WORDS), len(words)):
        capability = CAPABILITY_WORDS.get(fold(" ".join(words[place:])), "")
        if capability:
            return " ".join(words[:place]), capability
    return text, ""
