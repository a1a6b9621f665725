"""Queries as messages: a query is a tree, a ROS message is not, so its terms travel as a list. Pure.

Each term stands before its operands: ``light and not stale`` is ``and`` of two, ``type``, ``not``, ``freshness``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias, get_args

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
    NameIs,
    Not,
    Operator,
    Or,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
)
from homebot.devices.value import UNKNOWN, Value
from homebot.errors import UsageError
from homebot.messages.fields import UInt32
from homebot.messages.message import Message

__all__ = ["MAX_DEPTH", "MAX_TERMS", "QueryTerm", "query_terms", "read_terms"]

MAX_TERMS = 1000
"""Terms of one query."""

MAX_DEPTH = 50
"""Terms within each other."""

_TextTerm: TypeAlias = AreaIs | InArea | NameIs | HasText | FreshnessIs | ReachableIs | GatewayIs
"""Terms that are one text."""

TermKind: TypeAlias = Literal[
    "and",
    "or",
    "not",
    "type",
    "can",
    "area",
    "in_area",
    "name",
    "state",
    "text",
    "freshness",
    "reachable",
    "gateway",
    "fact",
    "disputed",
]

_TEXT_TERMS: dict[TermKind, type[_TextTerm]] = {
    "area": AreaIs,
    "in_area": InArea,
    "name": NameIs,
    "text": HasText,
    "freshness": FreshnessIs,
    "reachable": ReachableIs,
    "gateway": GatewayIs,
}
_KINDS: dict[type[Query], TermKind] = {term: kind for kind, term in _TEXT_TERMS.items()}
_OPERATORS: tuple[Operator, ...] = get_args(Operator)


class QueryTerm(Message):
    """One term of a query; see :mod:`homebot.devices.query.terms`.

    Attributes:
        kind: The kind of the term.
        operands: Of ``and``, ``or`` and ``not``: how many of the following terms, each with its own, it is made of.
        name: The capability of ``can`` and ``state``, the name of ``fact``; of ``type`` the word that was asked for.
        text: The value of ``fact``, and of every kind that has one text.
        operator: Of ``state``: ``=``, ``!=``, ``<``, ``<=``, ``>`` or ``>=``.
        value: Of ``state``: the value to compare with.
        types: Of ``type`` and ``state``: the device types.
        tag: Of ``type``: the kind of opening.
        flag: Of ``type``: whether announced words count; of ``can``: whether it must be settable.
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


def query_terms(query: Query) -> tuple[QueryTerm, ...]:
    """Return *query* as a list of terms."""
    found: list[QueryTerm] = []
    _add_terms(query, found)
    return tuple(found)


def read_terms(terms: Sequence[QueryTerm]) -> Query:
    """Return the query that *terms* are; none at all are one that everything fits.

    Raises:
        UsageError: They are no query; the message names the term.
    """
    if not terms:
        return And(())
    if len(terms) > MAX_TERMS:
        raise UsageError(f"the query has {len(terms):,} terms; {MAX_TERMS:,} is the limit")
    reader = _TermReader(terms)
    query = reader.read(1)
    if reader.position < len(terms):
        raise UsageError(
            f"term {reader.position + 1} of the query, {terms[reader.position].kind!r}, is of no other term"
        )
    return query


def _add_terms(query: Query, found: list[QueryTerm]) -> None:
    match query:
        case And(terms) | Or(terms):
            found.append(QueryTerm(kind="and" if isinstance(query, And) else "or", operands=len(terms)))
            for term in terms:
                _add_terms(term, found)
        case Not(term):
            found.append(QueryTerm(kind="not", operands=1))
            _add_terms(term, found)
        case TypeIs(word, types, tag, by_word):
            found.append(QueryTerm(kind="type", name=word, types=tuple(sorted(types)), tag=tag, flag=by_word))
        case StateIs(name, operator, value, types):
            sent = Value.of(value)
            types_sent = tuple(sorted(types))
            found.append(QueryTerm(kind="state", name=name, operator=operator, value=sent, types=types_sent))
        case CanDo(name, settable):
            found.append(QueryTerm(kind="can", name=name, flag=settable))
        case FactIs(name, value):
            found.append(QueryTerm(kind="fact", name=name, text=value))
        case IsDisputed():
            found.append(QueryTerm(kind="disputed"))
        case (
            AreaIs(text)
            | InArea(text)
            | NameIs(text)
            | HasText(text)
            | FreshnessIs(text)
            | ReachableIs(text)
            | GatewayIs(text)
        ):
            found.append(QueryTerm(kind=_KINDS[type(query)], text=text))


class _TermReader:
    """Reader of a list of terms, from the first to the last."""

    def __init__(self, terms: Sequence[QueryTerm]) -> None:
        self._terms = terms
        self.position = 0

    def read(self, depth: int) -> Query:
        """Read the next term with its operands."""
        if depth > MAX_DEPTH:
            raise UsageError(f"the query is nested deeper than {MAX_DEPTH} at term {self.position + 1}")
        if self.position >= len(self._terms):
            raise UsageError(f"the query ends after term {self.position}, where an operand is missing")
        term = self._terms[self.position]
        self.position += 1
        match term.kind:
            case "and" | "or":
                operands: list[Query] = []
                while len(operands) < term.operands:
                    operands.append(self.read(depth + 1))
                return And(tuple(operands)) if term.kind == "and" else Or(tuple(operands))
            case "not":
                return Not(self.read(depth + 1))
            case "state":
                return self._state(term)
            case "type":
                return TypeIs(term.name, frozenset(term.types), term.tag, term.flag)
            case "can":
                return CanDo(term.name, term.flag)
            case "fact":
                return FactIs(term.name, term.text)
            case "disputed":
                return IsDisputed()
            case _:
                return _TEXT_TERMS[term.kind](term.text)

    def _state(self, term: QueryTerm) -> StateIs:
        for operator in _OPERATORS:
            if operator == term.operator:
                return StateIs(term.name, operator, term.value.plain(), frozenset(term.types))
        raise UsageError(
            f"term {self.position} of the query has the operator {term.operator!r}, not one of =, !=, <, >"
        )
