"""Port of a convention: the way in which one family of devices uses MQTT. Pure: topics and payloads in, values out.

At its end is the base of homebot's own, which load what reads their messages with the first one.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from typing import Annotated, ClassVar, Generic, Protocol, TypeAlias, TypeVar, runtime_checkable

from pydantic import BaseModel, ConfigDict, Field

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, Publications
from homebot.devices.exposure import ExposedDevice
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import WireError

__all__ = [
    "Convention",
    "ConventionSettings",
    "LazyConvention",
    "MessageReader",
    "OfferPublisher",
    "ProblemReportingConvention",
    "PublishingConvention",
    "ReservingConvention",
    "SlicedConvention",
    "TextConvention",
    "TopicPrefix",
]

TopicPrefix: TypeAlias = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^+#\x00]*[^+#\x00/]$")]
"""The first levels of topics, without wildcards."""


class ConventionSettings(BaseModel):
    """The table of a convention; a key that it does not know is an error."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Convention(Protocol):
    """One way in which devices announce themselves; the plug-in group is ``homebot.mqtt_conventions``.

    A plug-in is a class that is called with the settings of its table, an instance of :attr:`Settings`. Where a device
    identifies itself in several messages, the object keeps those of unfinished devices, bounded; it reads no clock,
    does no input or output, and the same messages in the same order give the same result.

    Attributes:
        Settings: The model of its table; a field ``root`` is by default the home of the gateway.
        name: Its name, for example ``homeassistant``.
    """

    Settings: ClassVar[type[BaseModel]]
    name: ClassVar[str]

    @property
    def rejected(self) -> int:
        """Announcements that broke its rules, so far."""
        ...

    def filters(self) -> tuple[str, ...]:
        """Return the filters of its announcements, to be subscribed to one after the other, each awaited, at QoS 0."""
        ...

    def birth_messages(self) -> Publications:
        """Return what to publish, once subscribed and at every reconnect, so that devices announce themselves."""
        ...

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Take a message that matches one of the filters, and return what it describes of devices; often nothing.

        A convention whose devices identify themselves only when asked also returns what to ask them.

        Raises:
            WireError: The message belongs to this convention but breaks its rules; names field and value. What was
                taken before stays.
        """
        ...


class OfferPublisher(Protocol):
    """The other direction of a convention: shows others what homebot offers. It knows what it published."""

    def filters(self) -> tuple[str, ...]:
        """Return the filters of the commands that others send."""
        ...

    def is_own_topic(self, topic: str) -> bool:
        """Return whether *topic* is one on which it announces; what comes there is no device."""
        ...

    def publications(self, offer: ExposedDevice) -> Publications:
        """Return what makes *offer* be there, or be gone where it is withdrawn."""
        ...

    def states(
        self, offer: ExposedDevice, known: Mapping[tuple[str, str], PlainValue], changed: Collection[tuple[str, str]]
    ) -> Publications:
        """Return what publishes what is *known* of *offer* now that *changed* are news, by part and capability."""
        ...

    def read_command(self, topic: str, payload: bytes) -> tuple[Command, ...]:
        """Return the commands that a message on one of the filters is, in this order; none where it is none."""
        ...


@runtime_checkable
class TextConvention(Protocol):
    """A convention whose devices publish and take text, so that the topic alone names the device and what it is.

    Its filters are subscribed to at QoS 1, since states come there; no command topic may match them. It is given the
    first message on a topic, and no other as long as the device is there; see :attr:`DeviceAnnounced.text`.
    """

    def announced(self, topic: str) -> DeviceAnnounced | None:
        """Return the device that publishes on *topic*, or None when the topic is none of this convention's.

        Raises:
            WireError: The topic belongs to this convention but breaks its rules.
        """
        ...


@runtime_checkable
class ReservingConvention(Protocol):
    """A convention with topics that move more than one device."""

    def reserved(self) -> tuple[str, ...]:
        """Return the filters of the topics on which no announcement may have commands sent."""
        ...


@runtime_checkable
class SlicedConvention(Protocol):
    """A convention of which one message may describe many devices, so that it is better taken with pauses."""

    def read_message_in_slices(
        self, topic: str, payload: bytes, *, retained: bool
    ) -> Iterator[AnnouncementEvent | None]:
        """Read a message in steps of a few milliseconds; yield None where the caller may pause.

        Raises:
            WireError: As :meth:`Convention.read_message`.
        """
        ...


@runtime_checkable
class ProblemReportingConvention(Protocol):
    """A convention that may notice that something it should receive does not come."""

    def problems(self) -> tuple[str, ...]:
        """Return what is wrong now, in words for people; empty where nothing is."""
        ...


@runtime_checkable
class PublishingConvention(Protocol):
    """A convention that can also publish."""

    def publisher(self, owner: str, status_topic: str) -> OfferPublisher | None:
        """Return what publishes the offers of the homebot *owner*; None where the settings do not want it.

        Args:
            owner: A name that is lasting, and unique in the house.
            status_topic: Where that homebot publishes ``online`` and ``offline``.
        """
        ...


class MessageReader(Protocol):
    """The part of a convention that needs loading: it understands messages, and keeps what they report.

    Attributes:
        rejected: Announcements that broke the rules, so far.
    """

    rejected: int

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Do what :meth:`Convention.read_message` does."""
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

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Take a message and return what it describes of devices."""
        try:
            return self.reader.read_message(topic, payload, retained=retained)
        except WireError:
            self.reader.rejected += 1
            raise
