"""Tags at readers, and news of readers: the border between the readers' threads and the gateway. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, TypeAlias

from homebot.conventions.nfc.tag_content import TagContent

__all__ = ["PresentTag", "ReaderNews", "ReadersFound", "TagLeft", "TagSeen"]


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
