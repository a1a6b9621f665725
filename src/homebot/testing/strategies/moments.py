"""Points in time, round ones first."""

from __future__ import annotations

from functools import cache
from typing import Final

from hypothesis import strategies as st
from hypothesis.strategies import SearchStrategy

__all__ = ["moments"]

GRIDS: Final = (3600.0, 600.0, 60.0, 1.0)


@cache
def moments(latest: float, finest: float = 1.0) -> SearchStrategy[float]:
    """Return a strategy for seconds from 0 to *latest*, multiples of *finest*; full hours are simpler than minutes.

    Each is one choice of one number, so that it shrinks over all grids.
    """
    times = list(
        dict.fromkeys(number * grid for grid in GRIDS if grid >= finest for number in range(int(latest // grid) + 1))
    )
    return st.integers(0, len(times) - 1).map(times.__getitem__)
