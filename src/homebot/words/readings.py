"""Readings of a query for commands: a search may find too much or too little, but a command may not. Pure.

In ``lights in hall or kitchen``, ``lights or fans in hall`` and ``lights on or off in hall``, a word on only one side
may apply to both. ``hall lamp, hall lamp 2`` means two devices, although one of them has all these words.
"""

from dataclasses import dataclass
from itertools import groupby
from typing import Literal, TypeAlias

from homebot.devices.query.terms import And, HasText, InArea, Or, Query, TypeIs
from homebot.words.queries import Term, parse_alternatives

_Kind: TypeAlias = Literal["type", "area", "words", "group", "other"]
_Unit: TypeAlias = tuple[_Kind, str]
"""A term, or consecutive words, with its text."""


@dataclass(frozen=True, slots=True)
class Readings:
    """The alternatives that a query joins with ``or``.

    Attributes:
        alternatives: The alternatives according to :func:`homebot.words.queries.parse_query`.
        words: The alternatives that contain only search words, or ``all``.
        distributed: The alternatives if a word on only one side applies to both; empty if that makes no sense. For a
            query without ``or``, those joined by ``and`` or commas, if it may be a list of devices.
    """

    alternatives: tuple[str, ...]
    words: frozenset[str]
    distributed: tuple[str, ...]


def readings_of(text: str) -> Readings:
    """Return the readings of *text*; without ``or`` there is one alternative.

    Raises:
        UsageError: It is not a query.
    """
    alternatives = parse_alternatives(text)
    if len(alternatives) == 1 and (listed := _list(alternatives[0])):
        return Readings((text,), frozenset(), tuple(_distribute(listed)))
    sides = [_units(terms) for terms in alternatives]
    if len(sides) == 1 and len(sides[0]) == 1 and (inner := sides[0][0][1]).startswith("("):
        return readings_of(inner[1:-1])
    texts = tuple(map(_text, sides))
    distributed = tuple(_distribute(sides))
    return Readings(
        alternatives=texts,
        words=frozenset(_text(side) for side in sides if {kind for kind, _ in side} <= {"words"}),
        distributed=distributed if distributed != texts else (),
    )


def _list(terms: tuple[Term, ...]) -> list[list[_Unit]]:
    """Return the items of a list of devices, which each begin with a type, a room or words; empty if it is none."""
    starts = [place for place, (_, _, is_joined) in enumerate(terms) if is_joined]
    sides = [_units(terms[start:end]) for start, end in zip([0, *starts], [*starts, None], strict=True)]
    return sides if len(sides) > 1 and all(side[0][0] not in {"group", "other"} for side in sides) else []


def _units(terms: tuple[Term, ...]) -> list[_Unit]:
    """Return *terms* with consecutive words combined."""
    kinds = [(_kind(term, text), text) for term, text, _ in terms]
    units: list[_Unit] = []
    for kind, group in groupby(kinds, key=lambda one: one[0]):
        texts = [text for _, text in group]
        units += [(kind, " ".join(texts))] if kind == "words" else [(kind, one) for one in texts]
    return units


def _kind(term: Query, text: str) -> _Kind:
    if text.startswith("("):
        return "group"
    match term:
        case TypeIs() | Or((TypeIs(), *_)):
            return "type"
        case InArea():
            return "area"
        case HasText():
            return "words"
        case And(terms) if all(isinstance(one, HasText) for one in terms):
            return "words"
        case _:
            return "other"


def _distribute(sides: list[list[_Unit]]) -> list[str]:
    """Return the alternatives of *sides*; adjacent ones that differ in one unit each get the other's words."""
    found: list[str] = []
    place = 0
    while place < len(sides):
        end = place + 1
        while (
            end < len(sides) and (end == place + 1 or len(sides[end - 1]) == 1) and _joins(sides[end - 1], sides[end])
        ):
            end += 1
        first, last = sides[place], sides[end - 1]
        before, after = first[:-1], last[1:]
        if end == place + 1 or not _is_plausible([*before, first[-1], *after]):
            found += map(_text, sides[place:end])
        else:
            middle = [first[-1], *(side[0] for side in sides[place + 1 : end])]
            found += [_text([*before, _as(first[-1][0], unit), *after]) for unit in middle]
        place = end
    return found


def _joins(side: list[_Unit], following: list[_Unit]) -> bool:
    """Return whether *side* ends as *following* begins: with a type, words, or an area or other condition."""
    if not side or not following:
        return False
    kind, following_kind = side[-1][0], following[0][0]
    if kind == following_kind or (kind, following_kind) == ("area", "words"):
        return kind != "group"
    return {kind, following_kind} == {"area", "other"}


def _is_plausible(units: list[_Unit]) -> bool:
    kinds = [kind for kind, _ in units]
    return kinds.count("type") <= 1 and kinds.count("area") <= 1


def _as(kind: _Kind, unit: _Unit) -> _Unit:
    """Return *unit* as *kind*: words after an area and ``or`` may be an area."""
    return (kind, f"in {unit[1]}") if kind == "area" and unit[0] == "words" else unit


def _text(units: list[_Unit]) -> str:
    return " ".join(text for _, text in units) or "all"
