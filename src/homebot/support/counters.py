"""Counters of a component, declared with their severity."""

from dataclasses import field
from enum import StrEnum


class Severity(StrEnum):
    """Meaning of a count above 0.

    ``NORMAL``: nothing is wrong. ``FAULT``: it should be 0. ``LOSS``: it should be 0, and homebot is to answer for it.
    """

    NORMAL = "normal"
    FAULT = "fault"
    LOSS = "loss"


def fault() -> int:
    """Return the field of a dataclass for a counter that should stay 0, and begins with it."""
    return field(default=0, metadata={"severity": Severity.FAULT})


def loss() -> int:
    """Return the field of a dataclass for a counter that should stay 0, and that homebot is to answer for."""
    return field(default=0, metadata={"severity": Severity.LOSS})
