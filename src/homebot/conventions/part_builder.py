"""Builder of a part: its capabilities, with what reads and writes them, become its description. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from typing import Generic, TypeVar

from homebot.conventions.command_values import Writer
from homebot.conventions.description import AutoExpiry, DescribedPart, Publication
from homebot.conventions.payload import JsonMessage
from homebot.conventions.table_codec import CodedWriter, PayloadParser, Reader, TableCodec, json_object, raw_bytes
from homebot.devices.command_description import payload_digest
from homebot.devices.part import Capability, Category, Part

__all__ = ["BytesPart", "JsonPart", "PartBuilder", "with_own_ids"]

MessageT = TypeVar("MessageT")


class PartBuilder(Generic[MessageT]):
    """Collects what one part can do, and becomes its description.

    Its arguments are fields of :class:`homebot.devices.part.Part`.

    Attributes:
        parse_payload: Makes of a payload what the readers are given.
    """

    parse_payload: PayloadParser[MessageT]

    def __init__(
        self,
        part_id: str,
        service_type: str,
        *,
        name: str = "",
        advertised: str = "",
        tag: str = "",
        category: Category = "",
        guessed: bool = False,
    ) -> None:
        self._about = (part_id, service_type, name, advertised, tag, category, guessed)
        self._capabilities: dict[str, Capability] = {}
        self._readers: dict[str, tuple[Reader[MessageT], ...]] = {}
        self._event_readers: dict[str, tuple[Reader[MessageT], ...]] = {}
        self._writers: dict[str, Writer] = {}
        self._coded_writers: dict[str, CodedWriter] = {}
        self._writes: dict[str, None] = {}
        self._state_requests: dict[Publication, None] = {}
        self._expiries: tuple[AutoExpiry, ...] = ()
        self._remembers = False

    @property
    def is_empty(self) -> bool:
        """True if it can do nothing at all, so far."""
        return not self._capabilities

    def add_capability(
        self,
        name: str,
        *,
        readable: bool = True,
        writer: Writer | None = None,
        unit: str = "",
        bounds: tuple[float, ...] = (),
        options: tuple[str, ...] = (),
    ) -> None:
        """Have the capability *name*, settable where there is a *writer*. One that is neither is left out."""
        if not readable and writer is None:
            return
        make = _capability if len(options) <= _FEW_OPTIONS else _capability.__wrapped__
        self._capabilities[name] = make(name, readable, writer is not None, unit, bounds, options)
        if writer is not None:
            self._writers[name] = writer

    def add_coded_capability(
        self, name: str, writer: CodedWriter, *, readable: bool = True, options: tuple[str, ...] = ()
    ) -> None:
        """Add a capability as :meth:`add_capability`, for what may be set with a code alone."""
        self._capabilities[name] = Capability(name=name, readable=readable, settable=True, options=options)
        self._coded_writers[name] = writer

    def read_from(self, topic: str, reader: Reader[MessageT]) -> None:
        """Read every message on *topic* with *reader*."""
        self._readers[topic] = (*self._readers.get(topic, ()), reader)

    def read_events_from(self, topic: str, reader: Reader[MessageT]) -> None:
        """Read events from a topic as :meth:`read_from`, but not what the broker had retained: it happened before."""
        self._readers.setdefault(topic, ())
        self._event_readers[topic] = (*self._event_readers.get(topic, ()), reader)

    def add_command_topics(self, *topics: str) -> None:
        """Name the topics on which the part takes commands."""
        self._writes.update(dict.fromkeys(topics))

    def add_state_request(self, *publications: Publication) -> None:
        """Name what makes the device report the part's state."""
        self._state_requests.update(dict.fromkeys(publications))

    def add_expiry(self, *expiries: AutoExpiry) -> None:
        """Let values end by themselves."""
        self._expiries += expiries

    def remembers(self) -> None:
        """Note that its codec needs what was reported before; see :attr:`DescribedPart.remembers`."""
        self._remembers = True

    def build(self, payloads: object = None) -> DescribedPart:
        """Return the finished part.

        Args:
            payloads: Plain values of the announcement from which the payloads of its commands follow; None if they
                follow from topics and capabilities.
        """
        part_id, service_type, name, advertised, tag, category, guessed = self._about
        codec = TableCodec(self.parse_payload, self._readers, self._event_readers, self._writers, self._coded_writers)
        part = Part(
            id=part_id,
            name=name,
            service_type=service_type,
            advertised=advertised,
            tag=tag,
            category=category,
            guessed=guessed,
            capabilities=tuple(self._capabilities.values()),
            reads=tuple(self._readers),
            writes=tuple(self._writes),
            payloads="" if payloads is None else payload_digest(payloads),
        )
        return DescribedPart(
            part.slimmed(),
            codec,
            state_requests=tuple(self._state_requests),
            expiries=self._expiries,
            remembers=self._remembers,
        )


class JsonPart(PartBuilder[JsonMessage]):
    """A part whose readers are given a JSON object."""

    parse_payload = staticmethod(json_object)


class BytesPart(PartBuilder[bytes]):
    """A part whose readers are given the payload."""

    parse_payload = staticmethod(raw_bytes)


def with_own_ids(parts: Iterable[DescribedPart], most: int) -> tuple[DescribedPart, ...]:
    """Return the first *most* of *parts*; one whose id another has already gets a number behind it."""
    found: dict[str, DescribedPart] = {}
    counts: dict[str, int] = {}
    for one in islice(parts, most):
        part_id = one.part.id
        while part_id in found:
            counts[one.part.id] = counts.get(one.part.id, 1) + 1
            part_id = f"{one.part.id}_{counts[one.part.id]}"
        is_own = part_id == one.part.id
        found[part_id] = one if is_own else replace(one, part=one.part.model_copy(update={"id": part_id}))
    return tuple(found.values())


_FEW_OPTIONS = 50


@lru_cache(maxsize=512)
def _capability(  # the same few for all devices of a house: making one costs ten times as much as finding it
    name: str,
    readable: bool,  # noqa: FBT001 - only called above
    settable: bool,  # noqa: FBT001 - only called above
    unit: str,
    bounds: tuple[float, ...],
    options: tuple[str, ...],
) -> Capability:
    return Capability(name=name, readable=readable, settable=settable, unit=unit, bounds=bounds, options=options)
