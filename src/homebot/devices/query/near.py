"""Queries for what is near a robot. Pure."""

from __future__ import annotations

from collections.abc import Iterator

from homebot.devices.query.terms import And, IsNear, Query, leaves
from homebot.errors import UsageError

__all__ = ["split_near"]


def split_near(query: Query) -> tuple[IsNear | None, Query]:
    """Return the term of *query* that asks for what is near a robot, None if there is none, and the rest.

    Raises:
        UsageError: It is beside ``or`` or after ``not``, or there are several.
    """
    terms = tuple(_joined(query))
    rest = tuple(one for one in terms if not isinstance(one, IsNear))
    if any(isinstance(one, IsNear) for term in rest for one in leaves(term)):
        remedy = "write for example '(lamp or plug) near robot'"
        raise UsageError(f"what is near is asked of a whole query, not beside 'or' or after 'not'; {remedy}")
    near = [one for one in terms if isinstance(one, IsNear)]
    if len(near) > 1:
        raise UsageError("the query asks twice for what is near; one robot and one distance is the limit")
    return (near[0], And(rest)) if near else (None, query)


def _joined(query: Query) -> Iterator[Query]:
    """Yield the terms all of which must match."""
    if not isinstance(query, And):
        yield query
        return
    for term in query.terms:
        yield from _joined(term)
