"""The content of an NFC tag, and why one cannot be read or written. Pure."""

from __future__ import annotations

from dataclasses import dataclass

from homebot.devices.tags import TagProblem
from homebot.errors import PeerError

__all__ = ["MAX_MESSAGE", "TagContent", "TagError"]

MAX_MESSAGE = 8192
"""The longest NDEF message, in bytes, that homebot reads from a tag."""


class TagError(PeerError):
    """A tag that cannot be read or written.

    Attributes:
        problem: The reason, for programs.
    """

    def __init__(self, problem: TagProblem, text: str) -> None:
        super().__init__(text)
        self.problem: TagProblem = problem


@dataclass(frozen=True, slots=True)
class TagContent:
    """The content of a tag.

    Attributes:
        message: The NDEF message, not decoded; empty for none.
        capacity: The longest message that it holds, in bytes.
        is_writable: Whether it can be written.
    """

    message: bytes
    capacity: int
    is_writable: bool
