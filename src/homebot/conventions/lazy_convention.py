"""Base of homebot's own conventions: what reads their messages is loaded with the first one. Pure."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import ClassVar, Generic, Protocol, TypeVar

from pydantic import BaseModel

from homebot.conventions.description import AnnouncementEvent, Publications
from homebot.errors import WireError

__all__ = ["LazyConvention", "MessageReader"]


class MessageReader(Protocol):
    """The part of a convention that needs loading: it understands messages, and keeps what they report.

    Attributes:
        rejected: Announcements that broke the rules, so far.
    """

    rejected: int

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Do what :meth:`Convention.take` does."""
        ...


SettingsT = TypeVar("SettingsT", bound=BaseModel)
ReaderT = TypeVar("ReaderT", bound=MessageReader)


class LazyConvention(ABC, Generic[SettingsT, ReaderT]):
    """A convention that knows where devices announce themselves, and loads the rest when one does.

    A house uses one or two of the conventions that are subscribed to.
    """

    Settings: ClassVar[type[BaseModel]]
    name: ClassVar[str]

    def __init__(self, settings: SettingsT) -> None:
        self.settings = settings

    @abstractmethod
    def load_reader(self) -> ReaderT:
        """Import the reader's module and return a reader."""

    @cached_property
    def reader(self) -> ReaderT:
        """Return the reader of the messages; it is loaded when it is first asked for."""
        return self.load_reader()

    @property
    def is_loaded(self) -> bool:
        """True once there is a reader, as a message came."""
        return "reader" in self.__dict__

    @property
    def rejected(self) -> int:
        """Announcements that broke the rules, so far."""
        return self.reader.rejected if self.is_loaded else 0

    def birth_messages(self) -> Publications:
        """Return nothing: announcements are retained."""
        return ()

    def take(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Take a message and return what it describes of devices."""
        try:
            return self.reader.take(topic, payload, retained=retained)
        except WireError:
            self.reader.rejected += 1
            raise
