"""Tags at readers, and news of readers: the border between the readers' threads and the gateway. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

from homebot.devices.tags import TagProblem
from homebot.errors import PeerError

__all__ = ["MAX_MESSAGE", "PresentTag", "ReaderNews", "ReadersFound", "TagContent", "TagError", "TagLeft", "TagSeen"]

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


class PresentTag(Protocol):
    """A tag that is at a reader now. Its methods block, and belong to the reader's thread."""

    @property
    def uid(self) -> str:
        """Its number in hexadecimal digits."""

    @property
    def tag_type(self) -> str:
        """Its kind, in words."""

    def read(self) -> TagContent:
        """Return what is on it.

        Raises:
            TagError: It holds no NDEF message, or left.
        """

    def write(self, message: bytes) -> None:
        """Put an NDEF message on it in place of what is there.

        Raises:
            TagError: It does not take it, or left.
        """


@dataclass(frozen=True, slots=True)
class ReadersFound:
    """The readers that are there now.

    Attributes:
        readers: Their names.
    """

    readers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TagSeen:
    """A tag that was held to a reader, or written there.

    Attributes:
        reader: The reader.
        uid: Its number; empty where not even that could be read.
        tag_type: What kind of tag it is.
        content: What is on it; None where that could not be read.
        problem: Why not, as text.
    """

    reader: str
    uid: str
    tag_type: str
    content: TagContent | None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class TagLeft:
    """A tag that is not at a reader any more.

    Attributes:
        reader: The reader.
        uid: Its number.
    """

    reader: str
    uid: str


ReaderNews: TypeAlias = ReadersFound | TagSeen | TagLeft
