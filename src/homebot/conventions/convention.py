"""Port of a convention: the use of MQTT by one family of devices. Pure: topics and payloads in, values out."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Iterator, Mapping
from functools import cached_property
from typing import Annotated, ClassVar, Generic, Literal, Protocol, TypeAlias, TypeVar, runtime_checkable

from pydantic import BaseModel, ConfigDict, Field

from homebot.conventions.description import AnnouncementEvent, DeviceAnnounced, Publications
from homebot.devices.exposure import ExposedDevice
from homebot.devices.gateway_messages import Command
from homebot.devices.value import PlainValue
from homebot.errors import WireError

TopicPrefix: TypeAlias = Annotated[str, Field(min_length=1, max_length=200, pattern=r"^[^+#\x00]*[^+#\x00/]$")]
"""The first levels of topics, without wildcards."""


class ConventionSettings(BaseModel):
    """The table of a convention; unknown keys are errors."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)


class Convention(Protocol):
    """One way in which devices announce themselves; the plug-in group is ``homebot.mqtt_conventions``.

    A plug-in is a class with its table as the only argument, an instance of :attr:`Settings`. It stores the messages of
    incomplete devices, bounded; it reads no clock, does no input or output, and is deterministic.

    Attributes:
        Settings: The model of its table; a field ``root`` is by default the home of the gateway.
        name: Its name, for example ``homeassistant``.
    """

    Settings: ClassVar[type[BaseModel]]
    name: ClassVar[str]

    @property
    def rejected(self) -> int:
        """Number of invalid announcements."""

    def filters(self) -> tuple[str, ...]:
        """Return the filters of its announcements, to be subscribed to one after the other, each awaited, at QoS 0."""

    def birth_messages(self) -> Publications:
        """Return the requests of announcements, published after the subscriptions and at every reconnect."""

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the announced devices in a message on one of the filters; often none.

        For devices that identify themselves only on request, return the requests too.

        Raises:
            WireError: The message is invalid; names field and value. Earlier messages stay effective.
        """


class OfferPublisher(Protocol):
    """Publisher of homebot's exposed devices; it stores its publications."""

    def filters(self) -> tuple[str, ...]:
        """Return the filters of incoming commands."""

    def is_own_topic(self, topic: str) -> bool:
        """Return whether *topic* is one of its own announcements, which are no devices."""

    def publications(self, offer: ExposedDevice) -> Publications:
        """Return the publications that announce *offer*, or withdraw it."""

    def states(
        self, offer: ExposedDevice, known: Mapping[tuple[str, str], PlainValue], changed: Collection[tuple[str, str]]
    ) -> Publications:
        """Return the states of *offer* with *changed* ones of the *known* values, by part and capability."""

    def read_command(self, topic: str, payload: bytes) -> tuple[Command, ...]:
        """Return the commands in a message on one of the filters, in this order."""


@runtime_checkable
class TextConvention(Protocol):
    """A convention of text devices, identified by their topics alone.

    Its filters are subscribed to at QoS 1, because states come there; no command topic may match them. It only reads
    the first message of a device; see :attr:`DeviceAnnounced.text`.
    """

    def announced(self, topic: str) -> DeviceAnnounced | None:
        """Return the device that publishes on *topic*, or None for a foreign topic.

        Raises:
            WireError: The topic belongs to this convention but breaks its rules.
        """


@runtime_checkable
class ReservingConvention(Protocol):
    """A convention with command topics of several devices."""

    def reserved(self) -> tuple[str, ...]:
        """Return the filters of topics that no announcement may use for commands."""


@runtime_checkable
class ConfidentialConvention(Protocol):
    """A convention with announcements that may contain codes, so that no states are read on its filters."""

    has_codes: ClassVar[Literal[True]]


@runtime_checkable
class SlicedConvention(Protocol):
    """A convention with messages of many devices, which are read in slices."""

    def read_message_in_slices(
        self, topic: str, payload: bytes, *, retained: bool
    ) -> Iterator[AnnouncementEvent | None]:
        """Read a message in steps of a few milliseconds; yield None where the caller may pause.

        Raises:
            WireError: The message is invalid.
        """


@runtime_checkable
class ProblemReportingConvention(Protocol):
    """A convention that reports its problems, such as a missing message."""

    def problems(self) -> tuple[str, ...]:
        """Return the current problems, for the user; empty for none."""


@runtime_checkable
class HintingConvention(Protocol):
    """A convention that knows its devices also where it does not look for them."""

    def hint(self, topic: str) -> str:
        """Return the setting with which it would read *topic*, for the user; empty for a topic of others."""


@runtime_checkable
class PublishingConvention(Protocol):
    """A convention that can also publish."""

    def publisher(self, owner: str, status_topic: str) -> OfferPublisher | None:
        """Return the publisher of the homebot *owner*; None if it is disabled.

        Args:
            owner: A lasting name, unique in the house.
            status_topic: The topic of ``online`` and ``offline`` of that homebot.
        """


class MessageReader(Protocol):
    """The reader of a convention, imported with its first message; counts *rejected* announcements."""

    rejected: int

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Read a message as :meth:`Convention.read_message`."""


SettingsT = TypeVar("SettingsT", bound=BaseModel)
ReaderT = TypeVar("ReaderT", bound=MessageReader)


class LazyConvention(ABC, Generic[SettingsT, ReaderT]):
    """A convention with a reader that is imported with the first message: a house uses one or two of them."""

    Settings: ClassVar[type[BaseModel]]
    name: ClassVar[str]

    def __init__(self, settings: SettingsT) -> None:
        self.settings = settings

    @abstractmethod
    def load_reader(self) -> ReaderT:
        """Import the reader's module and return a reader."""

    @cached_property
    def reader(self) -> ReaderT:
        """Return the reader, imported on first use."""
        return self.load_reader()

    @property
    def is_loaded(self) -> bool:
        """True after the first message."""
        return "reader" in self.__dict__

    @property
    def rejected(self) -> int:
        """Number of invalid announcements."""
        return self.reader.rejected if self.is_loaded else 0

    def birth_messages(self) -> Publications:
        """Return nothing: announcements are retained."""
        return ()

    def read_message(self, topic: str, payload: bytes, *, retained: bool) -> tuple[AnnouncementEvent, ...]:
        """Return the announced devices in a message."""
        try:
            return self.reader.read_message(topic, payload, retained=retained)
        except WireError:
            self.reader.rejected += 1
            raise
