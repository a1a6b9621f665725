"""Roles that a report can have for one command. Pure."""

from __future__ import annotations

from enum import Enum

__all__ = ["ReportRole"]


class ReportRole(Enum):
    """Meaning of a report for one command.

    ``EFFECT``: the wanted value. ``ECHO``: the wanted value, repeated by a bridge. ``STEP``: a value on the way.
    ``ASTRAY``: a position farther away than the one before. ``UNDONE``: another value after the wanted one.
    ``REPEAT``: the same other value again. ``OTHERWISE``: another value. ``AGREES``: a value of another capability that
    the command does not contradict. ``ASIDE``: any other value.
    """

    EFFECT = "effect"
    ECHO = "echo"
    STEP = "step"
    ASTRAY = "astray"
    UNDONE = "undone"
    REPEAT = "repeat"
    OTHERWISE = "otherwise"
    AGREES = "agrees"
    ASIDE = "aside"
