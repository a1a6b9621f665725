"""Choices that shrink well.

When it shrinks, Hypothesis takes away only a few choices in a row, and all later ones must still fit. So what may be
left out of a house costs few choices while it is plain, and the number of choices does not depend on other things.
"""

from bisect import bisect_right
from collections.abc import Collection, Mapping
from functools import lru_cache
from itertools import accumulate
from typing import Final, TypeVar

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from homebot.config import Table
from homebot.errors import UsageError

MADE: Final = 1000
"""Strategies of one sort that are kept: to make one takes longer than to draw from it."""

GRIDS: Final = (3600.0, 600.0, 60.0, 1.0)

NameT = TypeVar("NameT", bound=str)
ValueT = TypeVar("ValueT")

Settings = Mapping[str, SearchStrategy[object]]


@st.composite
def optional(draw: DrawFn, settings: Settings) -> Table:
    """Draw tables with any of *settings*, in their order; the simplest has none."""
    if not settings or not draw(_switch):  # one choice where there are none
        return {}
    return {name: draw(value) for name, value in settings.items() if draw(_switch)}


def several(draw: DrawFn, each: SearchStrategy[ValueT], at_least: int, at_most: int) -> list[ValueT]:
    """Draw a list that is seldom empty: hypothesis's own are in half of all examples, and an empty house is no news."""
    values: list[ValueT] = []
    while len(values) < at_least or (draw(_more) and len(values) < at_most):
        values.append(draw(each))
    return values


@lru_cache(MADE)
def one_of(values: tuple[ValueT, ...]) -> SearchStrategy[ValueT]:
    """Return a strategy for one of *values*, the simplest first; the same for the same, since making one takes long.

    A single value makes a choice too: else all later choices would slip when the second of two rooms goes.
    """
    return st.sampled_from(values if len(values) > 1 else values * 2)


def target(names: tuple[ValueT, ...]) -> SearchStrategy[ValueT]:
    """Return a strategy for one of a list of things that shrinks itself.

    The last is the simplest: so whichever is meant stays meant while those behind it, and then those before it, go.
    """
    return one_of((*names[-1:], *names[:-1]))


@lru_cache(MADE)
def moments(latest: float, finest: float = 1.0) -> SearchStrategy[float]:
    """Return a strategy for seconds from 0 to *latest*, multiples of *finest*; full hours are simpler than minutes."""
    grids = [grid for grid in GRIDS if grid >= finest]
    *starts, end = accumulate((int(latest // grid) + 1 for grid in grids), initial=0)

    def moment(number: int) -> float:
        which = bisect_right(starts, number) - 1
        return (number - starts[which]) * grids[which]

    return st.integers(0, end - 1).map(moment)


def chosen(names: Collection[str], known: Collection[NameT], what: str) -> tuple[NameT, ...]:
    """Return those of *known* that are in *names*, in the order of *known*.

    Raises:
        UsageError: One of *names* is not known.
    """
    if unknown := sorted(set(names) - set(known)):
        raise UsageError(f"{unknown[0]!r} is no {what}; known are {', '.join(known)}")
    return tuple(name for name in known if name in names)


_switch = st.booleans()
_more = st.sampled_from((False, True, True, True, True, True))
