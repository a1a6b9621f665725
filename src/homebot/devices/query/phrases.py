"""Meaning of the phrases of a text query, and of an adjective beside a type. Pure."""

from __future__ import annotations

from dataclasses import replace

from homebot.devices.device_types import wanted_types
from homebot.devices.query.terms import And, CanDo, Not, Or, Query, StateIs, TypeIs, type_is
from homebot.devices.query.vocabulary import ABILITIES, ADJECTIVES, CAPABILITY_WORDS, CONDITIONS

__all__ = ["all_of", "is_meaningful", "meaning_of"]


def meaning_of(phrase: str) -> Query | None:
    """Return the term that *phrase*, folded, spells; None if it is no word of queries."""
    if not phrase:
        return None
    if (meant := CONDITIONS.get(phrase) or ABILITIES.get(phrase)) is not None:
        return meant
    if (states := ADJECTIVES.get(phrase)) is not None:
        return states[0] if len(states) == 1 else Or(states)
    capability = CAPABILITY_WORDS.get(phrase)
    if wanted_types(phrase) or phrase in {"sensor", "sensors"}:
        named = type_is(phrase)
        return named if capability is None else Or((named, CanDo(capability)))
    return None if capability is None else CanDo(capability)


def is_meaningful(word: str) -> bool:
    """Return whether *word*, folded, is a type, or an adjective."""
    return word in ADJECTIVES or word in CONDITIONS or word in ABILITIES or bool(type_is(word).types)


def all_of(terms: list[Query]) -> Query:
    """Return the query that all *terms* match, adjectives for the types beside them."""
    if not any(isinstance(term, TypeIs) for term in terms):
        terms = [_NOUNS.get(term, term) for term in terms]
    scoped = _with_scopes(terms)
    return scoped[0] if len(scoped) == 1 else And(tuple(scoped))


def _with_scopes(terms: list[Query]) -> list[Query]:
    """Restrict adjectives to the types beside them."""
    types = frozenset(one for term in terms if isinstance(term, TypeIs) for one in term.types)
    return [_scoped(term, types) for term in terms] if types else terms


def _scoped(term: Query, types: frozenset[str]) -> Query:
    if term in _ADJECTIVE_TERMS:
        match term:
            case StateIs():
                return replace(term, types=types)
            case Or(terms):
                return Or(tuple(replace(one, types=types) for one in terms if isinstance(one, StateIs)))
    return Not(_scoped(term.term, types)) if isinstance(term, Not) else term


_ADJECTIVE_TERMS = frozenset(states[0] if len(states) == 1 else Or(states) for states in ADJECTIVES.values())

_NOUNS: dict[Query, Query] = {
    states[0]: type_is(word) for word, states in ADJECTIVES.items() if len(states) == 1 and wanted_types(word)
}
"""Types with a word that is an adjective too, such as ``heating``, for that adjective without a type beside it."""
