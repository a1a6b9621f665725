"""Builder of a part from its capabilities with their readers and writers. Pure."""

from collections.abc import Iterable
from functools import lru_cache
from itertools import islice
from typing import Generic, TypedDict, TypeVar, Unpack

from homebot.conventions.command_values import Writer
from homebot.conventions.description import AutoExpiry, DescribedPart, Publication
from homebot.conventions.payload import JsonMessage
from homebot.conventions.table_codec import CodedWriter, JointWriter, PayloadParser, Reader, TableCodec, json_object
from homebot.devices.part import Capability, Category, CodeKind, Part, payload_digest

MessageT = TypeVar("MessageT")

_CODED = frozenset({"alarm", "lock"})
"""Capabilities for which other clients may send codes, unless the part reports on the topic of its commands."""


class PartFields(TypedDict, total=False):
    """Fields of :class:`homebot.devices.part.Part` that a part may have."""

    name: str
    advertised: str
    tag: str
    category: Category
    guessed: bool


class CapabilityFields(TypedDict, total=False):
    """Fields of :class:`homebot.devices.part.Capability` that a capability may have."""

    unit: str
    bounds: tuple[float, ...]
    options: tuple[str, ...]
    grid: tuple[float, ...]
    code: CodeKind


class PartBuilder(Generic[MessageT]):
    """Builder of a part.

    Args:
        commands: The topic of commands of all its settable capabilities, if they have only one.

    Attributes:
        parse_payload: Parses a payload into the message of the readers.
        joint: Writes several of its values by one message; None if no message can have several.
        fades: Whether its commands take a transition.
    """

    parse_payload: PayloadParser[MessageT]
    joint: JointWriter | None = None
    fades = False

    def __init__(self, part_id: str, service_type: str, *, commands: str = "", **fields: Unpack[PartFields]) -> None:
        self._id = part_id
        self._commands = commands
        self._service_type = service_type
        self._fields = fields
        self._capabilities: dict[str, Capability] = {}
        self._readers: dict[str, tuple[Reader[MessageT], ...]] = {}
        self._event_readers: dict[str, tuple[Reader[MessageT], ...]] = {}
        self._writers: dict[str, Writer] = {}
        self._coded_writers: dict[str, CodedWriter] = {}
        self._writes: dict[str, None] = {}
        self._state_requests: dict[Publication, None] = {}
        self._expiries: tuple[AutoExpiry, ...] = ()
        self._remembers = False
        self._sends_code = False

    @property
    def is_empty(self) -> bool:
        """True if it has no capability yet."""
        return not self._capabilities

    def add_capability(
        self, name: str, *, readable: bool = True, writer: Writer | None = None, **fields: Unpack[CapabilityFields]
    ) -> None:
        """Add the capability *name*, settable with a *writer*. Without any access it is left out."""
        if not readable and writer is None:
            return
        make = _capability if len(fields.get("options", ())) <= _MAX_SHARED_OPTIONS else Capability
        self._capabilities[name] = make(name=name, readable=readable, settable=writer is not None, **fields)
        if writer is not None:
            self._writers[name] = writer
            if self._commands:
                self._writes[self._commands] = None

    def add_coded_capability(
        self,
        name: str,
        writer: CodedWriter,
        *,
        sends_code: bool,
        readable: bool = True,
        options: tuple[str, ...] = (),
        code: CodeKind = "",
    ) -> None:
        """Add a settable capability as :meth:`add_capability`, with a code: see :attr:`DescribedPart.sends_code`."""
        self.add_capability(
            name, readable=readable, writer=lambda value, _transition: writer(value, ""), options=options, code=code
        )
        self._coded_writers[name] = writer
        self._sends_code = sends_code

    def read_from(self, topic: str, reader: Reader[MessageT]) -> None:
        """Read every message on *topic* with *reader*."""
        self._readers[topic] = (*self._readers.get(topic, ()), reader)

    def read_events_from(self, topic: str, reader: Reader[MessageT]) -> None:
        """Read events from a topic as :meth:`read_from`, without retained ones, which happened before."""
        self._readers.setdefault(topic, ())
        self._event_readers[topic] = (*self._event_readers.get(topic, ()), reader)

    def add_command_topics(self, *topics: str) -> None:
        """Add the topics of its commands."""
        self._writes.update(dict.fromkeys(topics))

    def add_state_request(self, *publications: Publication) -> None:
        """Add requests of its state."""
        self._state_requests.update(dict.fromkeys(publications))

    def add_expiry(self, *expiries: AutoExpiry) -> None:
        """Add expiries of values."""
        self._expiries += expiries

    def remembers(self) -> None:
        """Mark its codec as dependent on earlier reports; see :attr:`DescribedPart.remembers`."""
        self._remembers = True

    def build(self, payloads: object = None, *, digest: str = "") -> DescribedPart:
        """Return the finished part.

        Args:
            payloads: Plain values of the announcement that determine the payloads of commands; None if topics and
                capabilities determine them.
            digest: The digest of these values if several parts share them.
        """
        tables = self._readers, self._event_readers, self._writers, self._coded_writers
        codec = TableCodec(self.parse_payload, *tables, self.joint if len(self._writers) > 1 else None)
        part = Part(
            id=self._id,
            service_type=self._service_type,
            **self._fields,
            capabilities=tuple(self._capabilities.values()),
            reads=tuple(self._readers),
            writes=tuple(self._writes),
            payloads=digest if payloads is None else payload_digest(payloads),
            fades=self.fades,
        )
        return DescribedPart(
            part.slimmed(),
            codec,
            state_requests=tuple(self._state_requests),
            expiries=self._expiries,
            remembers=self._remembers,
            sends_code=self._sends_code
            or (not _CODED.isdisjoint(self._writers) and self._writes.keys().isdisjoint(self._readers)),
        )


class JsonPart(PartBuilder[JsonMessage]):
    """A part with readers of JSON objects."""

    parse_payload = staticmethod(json_object)


class BytesPart(PartBuilder[bytes]):
    """A part with readers of bytes."""

    parse_payload = bytes


def with_own_ids(parts: Iterable[DescribedPart], most: int) -> tuple[DescribedPart, ...]:
    """Return the first *most* of *parts*; a repeated id gets a number as suffix."""
    described_parts: dict[str, DescribedPart] = {}
    counts: dict[str, int] = {}
    for part in islice(parts, most):
        part_id = part.part.id
        while part_id in described_parts:
            counts[part.part.id] = counts.get(part.part.id, 1) + 1
            part_id = f"{part.part.id}_{counts[part.part.id]}"
        is_own = part_id == part.part.id
        described_parts[part_id] = part if is_own else part._replace(part=part.part.model_copy(update={"id": part_id}))
    return tuple(described_parts.values())


_MAX_SHARED_OPTIONS = 50


_capability = lru_cache(maxsize=512)(Capability)
"""The same few for all devices of a house: making one costs ten times as much as finding it."""
