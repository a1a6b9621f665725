"""Numbers of examples, rounds and devices: small and fixed in ``make test``, large in ``make nightly``."""

import os
from typing import Final

import pytest

NIGHTLY: Final = "NIGHTLY" in os.environ

EXAMPLES: Final = 25
"""The most generated cases of one test in ``make test``, the same in every run."""


nightly = pytest.mark.skipif(not NIGHTLY, reason="a long case of make nightly")


def size(usual: int, nightly: int) -> int:
    """Return *usual*, or *nightly* in ``make nightly``."""
    return nightly if NIGHTLY else usual


def examples(nightly: int) -> int:
    """Return *nightly* generated cases, or at most :data:`EXAMPLES` in ``make test``."""
    return size(min(nightly, EXAMPLES), nightly)
