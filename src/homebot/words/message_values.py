"""Values of the house, such as ``temperature of office``: in messages of routines, and compared. Pure."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Final, Literal

from homebot.devices.capabilities import CAPABILITIES, OWN
from homebot.devices.query.terms import And, Query
from homebot.errors import UsageError
from homebot.support.folding import fold
from homebot.support.numbers import to_number
from homebot.words.calculations import Arithmetic, Term, operands_of, read_calculation, with_operands
from homebot.words.phrases import CALCULATED, NAMES, SUN_VALUE, TWO_VALUES
from homebot.words.queries import parse_query
from homebot.words.tokens import split_at
from homebot.words.vocabulary import CAPABILITY_WORDS

_PLACE: Final = re.compile(r"\{([^{}]*)\}")
_EXAMPLE: Final = (
    "write it like {temperature of office}, {temperature of office * 2}, {count of light on}, {names of open windows}, "
    "{name}, {room}, {before}, {routine}, {time} or {now}"
)

_ANY: Final = And(())

_MAX_CAPABILITY_WORDS: Final = max(len(words.split()) for words in CAPABILITY_WORDS)


@dataclass(frozen=True, slots=True)
class MessageValue:
    """A value that is known when the message is sent.

    Attributes:
        kind: ``name`` and ``room`` of the first device that matches *words*, or without them of that which started the
            routine, ``routine`` for its own name, ``time`` for the time of day, ``now`` with the day, ``before`` for
            the value before the change that started it, ``value`` of the first device,
            ``names`` of all that match, with this value of each if there is one, ``count`` for their number, ``sun``
            for its angle, or ``calculated`` from *operands*.
        words: The query as text, in which names of devices count; of the sun ``elevation`` or ``azimuth``.
        term: The calculation with the texts of *operands*.
    """

    text: str
    kind: Literal["name", "room", "routine", "time", "now", "before", "value", "names", "count", "sun", "calculated"]
    query: Query = _ANY
    capability: str = ""
    words: str = ""
    term: Term = 0.0
    operands: tuple["MessageValue", ...] = ()

    @property
    def is_number(self) -> bool:
        """True if it is a number, once it is known."""
        is_measured = self.kind == "value" and CAPABILITIES.get(self.capability, OWN).kind == "number"
        return is_measured or self.kind in {"count", "sun", "calculated"}

    @property
    def asked(self) -> tuple["MessageValue", ...]:
        """The values of devices that it needs, or it itself."""
        return tuple(one for one in self.operands or (self,) if one.kind != "sun")


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
    return _PLACE.sub(lambda place: f"{{{with_operands(place[1], change)}}}", text)


def read_value(text: str) -> MessageValue:
    """Return the value *text*, such as ``temperature of office``, or a calculation with some.

    Raises:
        UsageError: It is none.
    """
    plain = " ".join(text.split())
    term = read_calculation(plain)
    if not isinstance(term, Arithmetic):
        return _read_single(plain)
    try:
        operands = tuple(dict.fromkeys(map(_read_single, operands_of(term))))
    except UsageError:
        with suppress(UsageError):  # a hyphen in a name
            return _read_single(plain)
        raise
    if strange := next((operand.text for operand in operands if not operand.is_number), ""):
        raise UsageError(f"{{{text}}}: {strange!r} is no number")
    return MessageValue(plain, "calculated", term=term, operands=operands)


def _read_single(plain: str) -> MessageValue:
    match plain.casefold():
        case ("name" | "room" | "routine" | "time" | "now" | "before") as kind:
            return MessageValue(plain, kind)
    if (sun := SUN_VALUE.match(plain)) is not None:
        return MessageValue(plain, "sun", words="azimuth" if sun["angle"].casefold() == "azimuth" else "elevation")
    for word in ("of", "in"):
        first, *rest = split_at(plain, word)
        if rest and (listed := NAMES.match(f"{first} of")) is not None:
            words, told = plain[len(first) + len(" of ") :], listed.get("capability", "")
            if told and fold(told) not in CAPABILITY_WORDS:
                raise UsageError(
                    f"{{{plain}}}: {told!r} is no value; write it like {{names with battery of battery<20}}"
                )
            return MessageValue(plain, "names", parse_query(words), CAPABILITY_WORDS.get(fold(told), ""), words)
        capability = CAPABILITY_WORDS.get(fold(first), "")
        words = plain[len(first) + len(word) + 1 :].strip()
        match fold(first):
            case ("name" | "room" | "count") as told if rest and word == "of":
                return MessageValue(plain, told, parse_query(words), words=words)
        if rest and capability:
            words = f"in {words}" if word == "in" else words
            return MessageValue(plain, "value", parse_query(words), capability, words)
    words, capability = split_capability(plain)
    if not capability:
        raise UsageError(f"{{{plain}}} is no value; {_EXAMPLE}")
    return MessageValue(plain, "value", parse_query(words), capability, words)


def read_limit(text: str) -> Comparison | None:
    """Return the condition ``{count of light on} above 2``, of a value in braces; None if it is none.

    Raises:
        UsageError: The value in braces is none, or no number.
    """
    value, closed, rest = text.partition("}")
    if value[:1] != "{" or not closed or (found := CALCULATED.match(rest.strip().removeprefix("is "))) is None:
        return None
    first, limit = read_value(value[1:]), to_number(found["limit"])
    if not first.is_number or limit is None:
        raise UsageError(f"{text!r}: write it like '{{count of light on}} above 2'")
    return Comparison(first, found["sign"] in {"above", "over"}, MessageValue(found["limit"], "calculated", term=limit))


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
        if value is None or value.kind != "value" or not value.is_number:
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
