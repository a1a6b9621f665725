"""Tags at readers, and reports of readers: messages from the readers' threads to the gateway. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

from homebot.conventions.nfc.tag_content import TagContent

__all__ = ["PresentTag", "ReaderNews", "ReadersFound", "TagLeft", "TagSeen"]


class PresentTag(Protocol):
    """A tag that is at a reader now. Its methods block; only the reader's thread calls them."""

    @property
    def uid(self) -> str:
        """Its number in hexadecimal digits."""

    @property
    def tag_type(self) -> str:
        """Its type, as text."""

    def read(self) -> TagContent:
        """Return its content.

        Raises:
            TagError: It is not formatted for NDEF, or was taken away.
        """

    def write(self, message: bytes) -> None:
        """Replace its content by an NDEF message.

        Raises:
            TagError: It refuses the message, or was taken away.
        """


@dataclass(frozen=True, slots=True)
class ReadersFound:
    """The readers that are connected now."""

    readers: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class TagSeen:
    """A tag that was held to a reader, or written there.

    Attributes:
        uid: Its number; empty if that could not be read.
        content: Its content; None if that could not be read.
        problem: The reason why it could not be read.
    """

    reader: str
    uid: str
    tag_type: str
    content: TagContent | None
    problem: str = ""


@dataclass(frozen=True, slots=True)
class TagLeft:
    """A tag that was taken away from a reader."""

    reader: str
    uid: str


ReaderNews: TypeAlias = ReadersFound | TagSeen | TagLeft
