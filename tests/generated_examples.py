"""How many examples the tests of generated cases get."""

from __future__ import annotations

from typing import Final

from hypothesis import settings

__all__ = ["FAST", "examples"]

FAST: Final = 20
"""The most of one test in ``make test-fast``, by its profile."""


def examples(count: int) -> int:
    """Return the examples of a test that wants *count*: so many, or :data:`FAST` in ``make test-fast``."""
    return min(count, FAST) if settings.default is settings.get_profile("fast") else count
