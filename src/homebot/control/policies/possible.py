"""Queries whatever is reported: what may fit them at any time. Pure."""

from __future__ import annotations

from homebot.devices.query import And, FreshnessIs, Not, Or, Query, ReachableIs, StateIs

__all__ = ["depends_on_reports", "without_reports", "without_states"]


def without_states(query: Query, *, is_possible: bool = True) -> Query:
    """Return the query for what may match *query*, whatever values are reported; else for what must match it."""
    return _without((StateIs,), query, is_possible=is_possible)


def without_reports(query: Query) -> Query:
    """Return the query for what may match *query*, whatever is reported, and whether or not it is."""
    return _without((StateIs, FreshnessIs, ReachableIs), query, is_possible=True)


def depends_on_reports(query: Query) -> bool:
    """Return whether what matches *query* changes by what is reported."""
    return without_reports(query) != query


def _without(kinds: tuple[type[Query], ...], query: Query, *, is_possible: bool) -> Query:
    if isinstance(query, kinds):
        return And(()) if is_possible else Or(())
    match query:
        case And(terms):
            return And(tuple(_without(kinds, term, is_possible=is_possible) for term in terms))
        case Or(terms):
            return Or(tuple(_without(kinds, term, is_possible=is_possible) for term in terms))
        case Not(term):
            return Not(_without(kinds, term, is_possible=not is_possible))
    return query
