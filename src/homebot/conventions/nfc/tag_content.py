"""The content of an NFC tag, and why one cannot be read or written. Pure."""

from __future__ import annotations

from dataclasses import dataclass

from homebot.devices.tags import TagProblem
from homebot.errors import PeerError

__all__ = ["MAX_MESSAGE", "TagContent", "TagError"]

MAX_MESSAGE = 8192
"""Bytes of an NDEF message that are read from a tag."""


class TagError(PeerError):
    """A tag that cannot be read or written.

    Attributes:
        problem: Why, for programs.
    """

    def __init__(self, problem: TagProblem, text: str) -> None:
        super().__init__(text)
        self.problem: TagProblem = problem


@dataclass(frozen=True, slots=True)
class TagContent:
    """The content of a tag.

    Attributes:
        message: The NDEF message, not looked into; empty for none.
        capacity: Bytes that one may have there.
        is_writable: Whether it may be changed.
    """

    message: bytes
    capacity: int
    is_writable: bool
