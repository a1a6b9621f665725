"""Values in the messages of routines, such as ``It is {temperature of office} in {name}``. Pure."""

import re
from dataclasses import dataclass
from typing import Final, Literal

from homebot.devices.query.terms import Query
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.words.queries import parse_query
from homebot.words.tokens import split_at
from homebot.words.triggers import split_capability
from homebot.words.vocabulary import CAPABILITY_WORDS

_PLACE: Final = re.compile(r"\{([^{}]*)\}")
_EXAMPLE: Final = "write it like {temperature of office}, {name}, {room}, {routine} or {time}"


@dataclass(frozen=True, slots=True)
class MessageValue:
    """A value that is known when the message is sent.

    Attributes:
        kind: ``name`` and ``room`` of the device that started the routine, ``routine`` for its own name, ``time`` for
            the time of day, or ``value`` of the first device that matches *query*.
        words: The query as text, in which names of devices count.
    """

    text: str
    kind: Literal["name", "room", "routine", "time", "value"]
    query: Query | None = None
    capability: str = ""
    words: str = ""


def read_message(text: str) -> tuple[str | MessageValue, ...]:
    """Return *text* in pieces: as it is, and the values in braces; empty if it has no values.

    Raises:
        UsageError: A value in braces is none.
    """
    pieces = _PLACE.split(text)
    return tuple(read_value(piece) if place % 2 else piece for place, piece in enumerate(pieces) if len(pieces) > 1)


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
        capability = CAPABILITY_WORDS.get(fold(first), "")
        if rest and capability:
            words = plain[len(first) + len(word) + 1 :].strip()
            words = f"in {words}" if word == "in" else words
            return MessageValue(plain, "value", parse_query(words), capability, words)
    words, capability = split_capability(plain)
    if not capability:
        raise UsageError(f"{{{text}}} is no value; {_EXAMPLE}")
    return MessageValue(plain, "value", parse_query(words), capability, words)
