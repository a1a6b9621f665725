"""Something that was learnt from commands, as it is kept over a restart."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["LearntRow"]


class LearntRow(NamedTuple):
    """One thing that was learnt.

    Attributes:
        kind: What it is about, such as ``witness``.
        name: Its name, one of its kind.
        record: What was learnt, as text; empty where it was forgotten.
        at: When it was learnt last, in seconds since the Unix epoch.
        command: The id of the command from which it was learnt last.
    """

    kind: str
    name: str
    record: str
    at: float
    command: str
