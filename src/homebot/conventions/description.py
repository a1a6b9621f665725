"""Description of an announced device, as a convention gives it, with the codec of each part. Pure values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, Protocol, TypeAlias, runtime_checkable

from homebot.devices.part import Part
from homebot.devices.value import PlainValue

__all__ = [
    "AnnouncementEvent",
    "AutoExpiry",
    "Availability",
    "AvailabilityMode",
    "AvailabilitySource",
    "Codec",
    "DescribedPart",
    "DeviceAnnounced",
    "DeviceRequest",
    "DeviceWithdrawn",
    "LastWillAvailability",
    "Publication",
    "Publications",
    "TakesCode",
    "TextEndpoint",
]

AvailabilityMode: TypeAlias = Literal["all", "any", "latest"]


class Publication(NamedTuple):
    """A message to publish.

    Attributes:
        topic: Where; no wildcards.
        payload: What.
        qos: 0, 1 or 2.
        retain: Whether the broker shall keep it.
    """

    topic: str
    payload: bytes
    qos: int = 0
    retain: bool = False


Publications: TypeAlias = tuple[Publication, ...]
"""What to publish, in this order."""


class Codec(Protocol):
    """The codec of one part: pure, and bounded in time and memory whatever it is given."""

    def topics(self) -> tuple[str, ...]:
        """Return the topic filters that it reads; wildcards only where the device declared them."""
        ...

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        """Return the value of each capability that a message reports; None for one that is now unknown.

        A message that reports nothing of this part, or cannot be understood, gives an empty mapping, and what was known
        stays. An event that the broker had kept is none. Nobody changes the mapping afterwards.
        """
        ...

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        """Return what to publish so that *capability* becomes *value*, on topics that the part names in ``writes``.

        Raises:
            RefusedError: The part cannot do that, or the value is out of its bounds; says which it takes.
        """
        ...


@runtime_checkable
class TakesCode(Protocol):
    """A codec of a part that may want a code, in addition to :class:`Codec`."""

    def write_with_code(self, capability: str, value: PlainValue, code: str) -> Publications:
        """Write as :meth:`Codec.write`, with a code. It is a secret: no error shows it.

        Raises:
            RefusedError: As there, or it is the wrong code, or the part takes none for that.
        """
        ...


class AutoExpiry(NamedTuple):
    """A value that ends by itself.

    Attributes:
        capability: Whose.
        after: Seconds after which it does.
        value: What it then is; None for unknown.
        only: Fade only from this value; None from any.
    """

    capability: str
    after: float
    value: PlainValue = None
    only: PlainValue = None


@dataclass(frozen=True, slots=True)
class DescribedPart:
    """A part and its codec.

    Attributes:
        part: What it is.
        codec: How its messages are read and its commands written.
        state_requests: What to publish so that it reports its state.
        expiries: Values that end by themselves.
        remembers: Whether the codec makes commands or readings out of what the part reported before. One that takes its
            place, because the device is described anew, is given the last messages again.
        availability: How it reports by itself whether it can be reached; None where it does not, or as the device does.
    """

    part: Part
    codec: Codec
    state_requests: Publications = ()
    expiries: tuple[AutoExpiry, ...] = ()
    remembers: bool = False
    availability: Availability | None = None


class AvailabilitySource(Protocol):
    """One topic that reports whether a device can be reached."""

    @property
    def topic(self) -> str:
        """The topic, or a filter where the device declared one."""
        ...

    def read(self, payload: bytes) -> bool | None:
        """Return whether it can, or None when *payload* means neither."""
        ...


class LastWillAvailability(NamedTuple):
    """The topic of a device's last will, and the two payloads there; see :class:`AvailabilitySource`.

    Attributes:
        topic: The topic.
        online: The payload of a device that can be reached.
        offline: The payload of one that cannot.
    """

    topic: str
    online: bytes
    offline: bytes

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device can be reached, or None when *payload* means neither."""
        return True if payload == self.online else False if payload == self.offline else None


class Availability(NamedTuple):
    """The topics on which a device reports whether it can be reached. Before the first message it is unknown.

    Attributes:
        sources: The topics; at least one.
        mode: Whether ``all`` must say yes, or ``any``, or the ``latest`` payload counts.
    """

    sources: tuple[AvailabilitySource, ...]
    mode: AvailabilityMode = "latest"


class TextEndpoint(NamedTuple):
    """The topics on which a device publishes and takes text by itself.

    Attributes:
        service_type: What it offers, as it is called in its topic.
        address: The topic that it publishes on, and nothing else does.
        command_address: The topic on which it takes commands.
    """

    service_type: str
    address: str
    command_address: str


@dataclass(frozen=True, slots=True)
class DeviceAnnounced:
    """A device as one announcement describes it. A later one with the same key takes its place.

    Attributes:
        key: Names the announcement: unique in its convention, and lasting, for example ``light/0x17_light``.
        convention: Which convention it is in.
        identifiers: Who the device is; see :func:`homebot.devices.identity.identifiers`. Announcements of one device
            share at least one; empty where it named none.
        name: What people call the device.
        parts: What it offers.
        topic: Where it was announced.
        area: The room that was announced for it.
        facts: Further facts, such as ``manufacturer``, ``model``, ``sw_version``, ``via_device``.
        availability: How it reports whether it can be reached, as a whole; None when it does not.
        owns: Topics that the device has for itself with all that is below them, because it was announced there or the
            bridge that publishes for it names its devices so; never because the announcement says so.
        native: Whether the convention is that of the device itself, or of the bridge that connects it; what it reports
            is preferred to what somebody else makes of the device.
        whole_device: Whether each announcement of the convention is of a whole device: two of them are never about the
            same one, unless they name one radio address.
        implies_alive: Whether the announcement is a sign of life of the device itself when it comes live.
        text: Where it publishes and takes text; its one part does, whose service type is empty where the vocabulary has
            none. It is announced by the first message on that topic, whatever it says, and gone with an empty one.
    """

    key: str
    convention: str
    identifiers: tuple[str, ...]
    name: str
    parts: tuple[DescribedPart, ...]
    topic: str
    area: str = ""
    facts: Mapping[str, str] = field(default_factory=dict)
    availability: Availability | None = None
    owns: tuple[str, ...] = ()
    implies_alive: bool = False
    native: bool = False
    whole_device: bool = False
    text: TextEndpoint | None = None

    @property
    def full_key(self) -> str:
        """Key of the gateway for it; a text device, and one of no convention, is distinct without."""
        return self.key if self.text is not None or not self.convention else f"{self.convention}:{self.key}"


@dataclass(frozen=True, slots=True)
class DeviceWithdrawn:
    """An announcement was taken back.

    Attributes:
        key: Which; see :class:`DeviceAnnounced`.
        why: The reason, in words.
        is_final: Whether the device is known to be gone. Otherwise its new announcement may follow in a moment.
        device: What is gone, where that is known: a directory may know it though the gateway does not.
    """

    key: str
    why: str
    is_final: bool = False
    device: DeviceAnnounced | None = None


class DeviceRequest(NamedTuple):
    """A convention knows of a device that identifies itself only when it is asked.

    The convention asks again at the device's next sign of life as long as no answer came, so a question may be dropped.
    The gateway may send questions slowly, one device after the other; of two with the same key the later one counts.

    Attributes:
        key: Whom it asks; unique in its convention.
        publications: What to publish, in this order. Answers come on the convention's own filters.
    """

    key: str
    publications: Publications


AnnouncementEvent: TypeAlias = DeviceAnnounced | DeviceWithdrawn | DeviceRequest
