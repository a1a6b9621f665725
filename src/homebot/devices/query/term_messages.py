"""Form of a query as a message. Pure.

A query is a tree but a ROS message is not, so on the graph its terms are a list, each before its operands: ``light and
not stale`` is ``and`` of two, ``type``, ``not``, ``freshness``.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, get_args

from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    IsNear,
    IsUnapproved,
    NameIs,
    Not,
    Operator,
    Or,
    PartIs,
    Query,
    ReachableIs,
    StateIs,
    TextTerm,
    TypeIs,
)
from homebot.devices.value import UNKNOWN, Value
from homebot.errors import UsageError
from homebot.messages.message import Message, UInt32

MAX_TERMS = 1000
"""The limit of terms of one query."""

MAX_DEPTH = 50
"""The limit of nested terms."""

_TextQuery: TypeAlias = AreaIs | InArea | NameIs | PartIs | HasText | FreshnessIs | ReachableIs | GatewayIs
_TextKind: TypeAlias = Literal["area", "in_area", "name", "part", "text", "freshness", "reachable", "gateway"]
TermKind: TypeAlias = Literal[
    _TextKind, "and", "or", "not", "type", "can", "state", "fact", "near", "disputed", "unapproved", "words"
]

_TEXT_KINDS: dict[type[_TextQuery], _TextKind] = {
    AreaIs: "area",
    InArea: "in_area",
    NameIs: "name",
    PartIs: "part",
    HasText: "text",
    FreshnessIs: "freshness",
    ReachableIs: "reachable",
    GatewayIs: "gateway",
}
_TEXT_TERMS: dict[str, type[_TextQuery]] = {kind: term for term, kind in _TEXT_KINDS.items()}
_OPERATORS: dict[str, Operator] = {operator: operator for operator in get_args(Operator)}


class QueryTerm(Message):
    """One term of a query on the graph.

    Attributes:
        operands: For ``and``, ``or`` and ``not``: the number of following terms, with their operands, that it joins.
        name: The capability of ``can`` and ``state``, the name of ``fact``, the requested word of ``type``.
        text: The value of ``fact``, the robot of ``near``, the part of ``state``, the text of every kind with one text,
            and a whole query as people write it for ``words``.
        operator: For ``state``: ``=``, ``!=``, ``<``, ``<=``, ``>`` or ``>=``.
        value: For ``state``: the value to compare with; for ``near``: the longest way in metres, unknown for any.
        types: For ``type`` and ``state``: the device types.
        tag: For ``type``: the kind of opening.
        flag: For ``type``: whether announced words count; for ``can``: whether it must be settable.
    """

    kind: TermKind
    operands: UInt32 = 0
    name: str = ""
    text: str = ""
    operator: str = ""
    value: Value = UNKNOWN
    types: tuple[str, ...] = ()
    tag: str = ""
    flag: bool = False


def query_words(text: str) -> tuple[QueryTerm, ...]:
    """Return the query *text* as a term, for the directory, which knows what is called so; empty for all."""
    return (QueryTerm(kind="words", text=text),) if text else ()


def query_terms(query: Query) -> tuple[QueryTerm, ...]:
    """Return *query* as a list of terms."""
    written: list[QueryTerm] = []
    waiting: list[Query] = [query]
    while waiting:
        match waiting.pop():
            case And(operands):
                written.append(QueryTerm(kind="and", operands=len(operands)))
                waiting += reversed(operands)
            case Or(operands):
                written.append(QueryTerm(kind="or", operands=len(operands)))
                waiting += reversed(operands)
            case Not(operand):
                written.append(QueryTerm(kind="not", operands=1))
                waiting.append(operand)
            case TextTerm(text) as term:
                written.append(QueryTerm(kind=_TEXT_KINDS[type(term)], text=text))
            case term:
                written.append(_WRITERS[type(term)](term))
    return tuple(written)


def read_terms(terms: Sequence[QueryTerm], parse: Callable[[str], Query] | None = None) -> Query:
    """Return the query in *terms*; without terms, everything matches.

    Args:
        parse: Reads the queries in it that are texts; by default none may be.

    Raises:
        UsageError: They are not a query; the message names the term.
    """
    if not terms:
        return And(())
    if len(terms) > MAX_TERMS:
        raise UsageError(f"the query has {len(terms):,} terms; {MAX_TERMS:,} is the limit")
    read: list[tuple[Query, int, int]] = []  # from the end: each query with its depth and the number of its first term
    for number in range(len(terms), 0, -1):
        term = terms[number - 1]
        if term.kind not in _JOINS:
            leaf = parse(term.text) if parse is not None and term.kind == "words" else _READERS[term.kind](term, number)
            read.append((leaf, 1, number))
            continue
        count = 1 if term.kind == "not" else term.operands
        if count > len(read):
            raise UsageError(f"the query ends after term {len(terms)}, where an operand of term {number} is missing")
        operands, depth = [], 1
        for _ in range(count):
            operand, below, _ = read.pop()
            operands.append(operand)
            depth = max(depth, below + 1)
        if depth > MAX_DEPTH:
            raise UsageError(f"the query is nested deeper than {MAX_DEPTH} below term {number}")
        read.append((_JOINS[term.kind](tuple(operands)), depth, number))
    if len(read) > 1:
        extra = read[-2][2]
        raise UsageError(f"term {extra} of the query, {terms[extra - 1].kind!r}, is not an operand of any other term")
    return read[0][0]


def _write_type(term: TypeIs) -> QueryTerm:
    return QueryTerm(kind="type", name=term.word, types=tuple(sorted(term.types)), tag=term.tag, flag=term.by_word)


def _write_state(term: StateIs) -> QueryTerm:
    value, types = Value.of(term.value), tuple(sorted(term.types))
    name, operator = term.capability, term.operator
    return QueryTerm(kind="state", name=name, text=term.part, operator=operator, value=value, types=types)


def _read_state(term: QueryTerm, number: int) -> StateIs:
    operator = _OPERATORS.get(term.operator)
    if operator is None:
        known = ", ".join(_OPERATORS)
        raise UsageError(f"term {number} of the query has the operator {term.operator!r}, not one of {known}")
    return StateIs(term.name, operator, term.value.plain(), frozenset(term.types), term.text)


def _write_near(term: IsNear) -> QueryTerm:
    metres = UNKNOWN if math.isinf(term.within) else Value.of(term.within)
    return QueryTerm(kind="near", text=term.robot, value=metres)


def _read_near(term: QueryTerm, number: int) -> IsNear:
    metres = math.inf if term.value == UNKNOWN else term.value.plain()
    if not isinstance(metres, float) or not metres >= 0:
        raise UsageError(f"term {number} of the query has the metres {metres!r}, not a number from 0")
    return IsNear(term.text, metres)


def _refuse_words(_: QueryTerm, number: int) -> Query:
    raise UsageError(f"term {number} of the query is a text, which only the directory reads")


def _read_text(term: QueryTerm, _number: int) -> Query:
    return _TEXT_TERMS[term.kind](term.text)


_JOINS: Mapping[str, Callable[[tuple[Query, ...]], Query]] = {
    "and": And,
    "or": Or,
    "not": lambda operands: Not(operands[0]),
}

_WRITERS: Mapping[type[Query], Callable[[Any], QueryTerm]] = {
    TypeIs: _write_type,
    StateIs: _write_state,
    CanDo: lambda term: QueryTerm(kind="can", name=term.name, flag=term.settable),
    FactIs: lambda term: QueryTerm(kind="fact", name=term.name, text=term.value),
    IsNear: _write_near,
    IsDisputed: lambda _: QueryTerm(kind="disputed"),
    IsUnapproved: lambda _: QueryTerm(kind="unapproved"),
}
"""Writers for the kinds of terms that join no others and have more than one text."""

_READERS: Mapping[str, Callable[[QueryTerm, int], Query]] = {
    "type": lambda term, _: TypeIs(term.name, frozenset(term.types), term.tag, term.flag),
    "state": _read_state,
    "can": lambda term, _: CanDo(term.name, term.flag),
    "fact": lambda term, _: FactIs(term.name, term.text),
    "near": _read_near,
    "disputed": lambda _term, _: IsDisputed(),
    "unapproved": lambda _term, _: IsUnapproved(),
    **dict.fromkeys(_TEXT_TERMS, _read_text),
    "words": _refuse_words,
}
"""Readers for each kind of message, given its number."""
