"""Queries that guess nothing, for permissions and bans of the owner: a misspelt word would match nothing. Pure."""

from __future__ import annotations

from homebot.devices.query.near import split_near
from homebot.devices.query.parse import parse_query
from homebot.devices.query.terms import And, HasText, Not, Or, Query
from homebot.devices.query.vocabulary import CAPABILITY_WORDS, TYPE_WORDS
from homebot.errors import UsageError
from homebot.support.folding import is_typo

__all__ = ["parse_exact_query", "parse_lasting_query"]


def parse_exact_query(text: str) -> Query:
    """Return the query that *text* is, of types, capabilities, rooms and other fields.

    Raises:
        UsageError: It is no query, or has a word that would be searched for in all texts of devices; names the word.
    """
    query = parse_lasting_query(text)
    if word := _free_text(query):
        meant = sorted(one for one in {*TYPE_WORDS, *CAPABILITY_WORDS} if is_typo(word, one))
        hint = (
            f"did you mean {' or '.join(meant)}?"
            if meant
            else 'searched words may fit anything; write name="…" or id="…" for one device'
        )
        raise UsageError(f"{word!r} is neither a type nor a capability; {hint}")
    return query


def parse_lasting_query(text: str) -> Query:
    """Return the query that *text* is, for a rule that a device fits or not, wherever a robot is.

    Raises:
        UsageError: It is no query, or asks for what is near a robot.
    """
    query = parse_query(text)
    if split_near(query)[0] is not None:
        raise UsageError("a rule cannot ask for what is near a robot; name a room instead")
    return query


def _free_text(query: Query) -> str:
    """Return a word of *query* that is searched for in all texts of devices; empty if there is none."""
    match query:
        case HasText(word):
            return word
        case And(terms) | Or(terms):
            return next(filter(None, map(_free_text, terms)), "")
        case Not(term):
            return _free_text(term)
        case _:
            return ""
