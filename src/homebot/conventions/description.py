"""Description of an announced device, with the codec of each part, and the work of reading a message. Pure values."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Final, Literal, NamedTuple, Protocol, TypeAlias, runtime_checkable

from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.errors import WireError

AvailabilityMode: TypeAlias = Literal["all", "any", "latest"]


class Publication(NamedTuple):
    """A message to publish."""

    topic: str
    payload: bytes
    qos: int = 0
    retain: bool = False


Publications: TypeAlias = tuple[Publication, ...]
"""Messages to publish, in this order."""


class Codec(Protocol):
    """The codec of one part: pure, and bounded in time and memory for any input."""

    def topics(self) -> tuple[str, ...]:
        """Return its topic filters, with wildcards only if the device declared them."""

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Mapping[str, PlainValue]:
        """Return the reported value of each capability; None for an unknown one.

        The mapping is empty for an invalid message, one without values of this part, and a retained event; known values
        stay. It is never changed.
        """

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        """Return the command that sets *capability*, on topics in ``writes`` of the part.

        Raises:
            RefusedError: The capability is not settable, or the value is invalid; names the valid ones.
        """


@runtime_checkable
class TakesCode(Protocol):
    """A codec of a part that may want a code, in addition to :class:`Codec`."""

    def write_with_code(self, capability: str, value: PlainValue, code: str) -> Publications:
        """Return the command as :meth:`Codec.write`, with a code, which no error shows.

        Raises:
            RefusedError: As there, or the code is wrong, or the capability takes none.
        """


@runtime_checkable
class WritesSeveral(Protocol):
    """A codec of a part with one message for several settings, in addition to :class:`Codec`."""

    def write_several(
        self, values: Mapping[str, PlainValue], *, transition: float = 0.0
    ) -> tuple[Publications, Collection[str]]:
        """Return the command that sets the first of *values* as :meth:`Codec.write`, and the names that it sets."""


@runtime_checkable
class AsksMembers(Protocol):
    """A codec of a group whose bridge reports values for members unheard, in addition to :class:`Codec`."""

    def questions(self, sent: Publications) -> Publications:
        """Return the requests to the members for the values that the command *sent* changes; for none, for all."""


class AutoExpiry(NamedTuple):
    """The expiry of a value: *after* seconds it becomes *value*, if it is *only* or that is None."""

    capability: str
    after: float
    value: PlainValue = None
    only: PlainValue = None


class DescribedPart(NamedTuple):
    """A part and its codec.

    Attributes:
        remembers: Whether the codec depends on earlier reports. Its successor in a new description reads the last
            messages again.
        availability: Its own availability; None if it is that of the device.
        sends_code: Whether its commands may contain a code, so that no states are read on their topics.
        refusal: Returns why the device refuses the messages of a command, by its last message; empty if it does
            not. None if its reports do not say. Never raises.
    """

    part: Part
    codec: Codec
    state_requests: Publications = ()
    expiries: tuple[AutoExpiry, ...] = ()
    remembers: bool = False
    availability: Availability | None = None
    sends_code: bool = False
    refusal: Callable[[Publications], str] | None = None


class AvailabilitySource(Protocol):
    """One topic of the availability of a device."""

    @property
    def topic(self) -> str:
        """The topic, or a filter where the device declared one."""

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device is reachable; None for any other payload."""


class LastWillAvailability(NamedTuple):
    """The topic of a device's last will, and its two payloads; see :class:`AvailabilitySource`."""

    topic: str
    online: bytes
    offline: bytes

    def read(self, payload: bytes) -> bool | None:
        """Return whether the device is reachable; None for any other payload."""
        return True if payload == self.online else False if payload == self.offline else None


class Availability(NamedTuple):
    """The availability of a device, unknown before the first message.

    Attributes:
        sources: The topics; at least one.
        mode: Whether ``all`` or ``any`` must be online, or the ``latest`` payload decides.
    """

    sources: tuple[AvailabilitySource, ...]
    mode: AvailabilityMode = "latest"


TRACKER_SILENCE: Final = 86_400.0
"""Seconds; a phone that stays where it is tells nothing for hours, and an iPhone nothing for most of a day."""


class TextEndpoint(NamedTuple):
    """The topics of a text device.

    Attributes:
        service_type: Its service type, in the spelling of its topic.
        address: Its state topic, used by no other device.
        command_address: Its command topic.
    """

    service_type: str
    address: str
    command_address: str


class DeviceAnnounced(NamedTuple):
    """The description of a device in one announcement, which replaces an earlier one with its key.

    Attributes:
        key: Its lasting key, unique in its convention, for example ``light/0x17_light``.
        identifiers: See :func:`homebot.devices.identity.identifiers`. Announcements of one device share at least one;
            empty if it has none.
        name: Its name for people; empty if another announcement of the device may name it.
        area: The announced room.
        facts: Further facts, such as ``manufacturer``, ``model``, ``sw_version``, ``via_device``.
        availability: The availability of the whole device; None if it reports none.
        owns: Topics of the device alone, with all topics below, proven by the topic of the announcement or the naming
            of its bridge, never by the content of the announcement.
        native: Whether the convention is that of the device, or of the bridge that connects it; its values are
            preferred to those of other programs.
        whole_device: Whether each announcement of the convention is a whole device: two of them are never the same
            one, unless they have one radio address.
        implies_alive: Whether a live announcement is a sign of life of the device.
        text: The topics of a text device; the service type of its only part is empty if the vocabulary has none. It is
            announced by any first message on its topic, and withdrawn by an empty one.
        stale_after: Seconds of silence after which it counts as stale; 0 for the gateway's default.
    """

    key: str
    convention: str
    identifiers: tuple[str, ...]
    name: str
    parts: tuple[DescribedPart, ...]
    topic: str
    area: str = ""
    facts: Mapping[str, str] = MappingProxyType({})
    availability: Availability | None = None
    owns: tuple[str, ...] = ()
    implies_alive: bool = False
    native: bool = False
    whole_device: bool = False
    text: TextEndpoint | None = None
    stale_after: float = 0.0

    @property
    def full_key(self) -> str:
        """Key in the gateway, with the convention, except of a text device or one without convention."""
        return self.key if self.text is not None or not self.convention else f"{self.convention}:{self.key}"


@dataclass(frozen=True, slots=True)
class DeviceWithdrawn:
    """The withdrawal of an announcement.

    Attributes:
        key: See :class:`DeviceAnnounced`.
        why: The reason, for the user.
        is_final: Whether the device is gone. Otherwise a new announcement may follow in a moment.
        device: The device, if it is known: a directory may know it although the gateway does not.
    """

    key: str
    why: str
    is_final: bool = False
    device: DeviceAnnounced | None = None


class DeviceRequest(NamedTuple):
    """A request to a device that identifies itself only on request; answers come on the convention's filters.

    The gateway may send requests slowly or drop one: without an answer the convention repeats it at the device's next
    sign of life. A later request replaces one with its key, which is unique in its convention.
    """

    key: str
    publications: Publications


class GroupsListed(NamedTuple):
    """The members of all groups of a bridge, which announces the groups elsewhere; it replaces the last list.

    The bridge reports values for members unheard.

    Attributes:
        source: The topic of the list.
        members: See :attr:`homebot.devices.part.Part.members`; by identifier of the group's device.
    """

    source: str
    members: Mapping[str, tuple[str, ...]]


AnnouncementEvent: TypeAlias = DeviceAnnounced | DeviceWithdrawn | DeviceRequest | GroupsListed | WireError
"""What a message has; an error names a part of it that is invalid and left out."""


MAX_WORK: Final = 30_000
"""Steps of all readers of a message, beside those that each has for itself; a step is about a microsecond."""

work_left: Final = ContextVar[int | None]("work_left", default=None)
"""The steps that are left for the message that this task reads; None if it reads none."""

begin_message: Final[Callable[[], object]] = partial(work_left.set, MAX_WORK)
"""Let the readers of the next message, in this task, have :data:`MAX_WORK` to share."""


def as_group(described: DescribedPart, members: tuple[str, ...]) -> DescribedPart:
    """Return a part as a group of *members* whose bridge reports values for these unheard."""
    echoed = tuple(
        [capability.model_copy(update={"echoed": capability.readable}) for capability in described.part.capabilities]
    )
    return described._replace(part=described.part.model_copy(update={"capabilities": echoed, "members": members}))
