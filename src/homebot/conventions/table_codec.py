"""A codec made of tables: readers by topic, and writers by capability. Pure."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from functools import partial
from operator import attrgetter
from types import MappingProxyType
from typing import Generic, Never, TypeAlias, TypeVar

from homebot.conventions.command_values import Writer, require_transition
from homebot.conventions.description import DescribedPart, Publications
from homebot.conventions.joint_message import merged, without_switch
from homebot.conventions.payload import (
    NO_READINGS,
    JsonMessage,
    Readings,
    compact_json,
    parse_object,
    shown,
    to_json,
    unreadable,
)
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError
from homebot.mqtt.topics import topic_matches

MessageT = TypeVar("MessageT")

Reader: TypeAlias = Callable[[MessageT], Readings]
"""Reads a parsed message. Never raises."""

CodedWriter: TypeAlias = Callable[[PlainValue, str], Publications]
"""Writes a value with a code, which may be empty; raises RefusedError."""

JointWriter: TypeAlias = Callable[
    [Mapping[str, Writer], Mapping[str, PlainValue], float], tuple[Publications, Collection[str]]
]
"""Writes the first of several values, with those that one message can have; returns also the names of those.

It gets the writers of single values too, and a transition in seconds; raises RefusedError.
"""

PayloadParser: TypeAlias = Callable[[bytes], MessageT | None]
"""Parses a payload into the message of readers; returns None for an invalid one. Never raises."""

_NONE: Mapping[str, Never] = MappingProxyType({})
"""One shared empty table: most tables of a house are empty."""


def json_object(payload: bytes) -> JsonMessage | None:
    """Parse a payload for readers of a JSON object, which they share."""
    message = to_json(payload)
    if isinstance(message, dict):
        return message
    unreadable(payload, "a JSON object")
    return None


def write_one_object(
    writers: Mapping[str, Writer], values: Mapping[str, PlainValue], transition: float
) -> tuple[Publications, Collection[str]]:
    """Write values as :data:`JointWriter` by merging their messages, each a JSON object, if they do not differ."""
    settings = without_switch(values)
    (name, value), *others = settings.items()
    written, names = writers[name](value, transition), [name]
    for other, value in others:
        further = writers[other](value, transition)
        if len(written) == len(further) == 1 and written[0]._replace(payload=b"") == further[0]._replace(payload=b""):
            both = merged(parse_object(written[0].payload), parse_object(further[0].payload))
            if both is not None:
                written = (written[0]._replace(payload=compact_json(both).encode()),)
                names.append(other)
    return written, [*names, *(values.keys() - settings.keys())]


def write_mode_for_switch(
    writers: Mapping[str, Writer], values: Mapping[str, PlainValue], transition: float
) -> tuple[Publications, Collection[str]]:
    """Write one value as :data:`JointWriter`, the mode of a thermostat for its switch too, which it is."""
    settings = without_switch(values)
    name, value = next(iter(settings.items()))
    return writers[name](value, transition), (name, *(values.keys() - settings.keys()))


class TableCodec(Generic[MessageT]):
    """A codec made of tables; see :class:`homebot.conventions.description.Codec`.

    Args:
        parse_payload: Parses a payload for the readers.
        readers: Readers by topic, or by a filter that the device declared; has all topics.
        event_readers: Readers of live messages by topic.
        coded_writers: Writers with a code by capability, each of which is among *writers* without one.
        joint: Writes several values by one message; None if no message can have several.
    """

    __slots__ = ("_coded_writers", "_event_readers", "_joint", "_parse_payload", "_readers", "_wild", "_writers")

    def __init__(
        self,
        parse_payload: PayloadParser[MessageT],
        readers: Mapping[str, tuple[Reader[MessageT], ...]],
        event_readers: Mapping[str, tuple[Reader[MessageT], ...]],
        writers: Mapping[str, Writer],
        coded_writers: Mapping[str, CodedWriter] | None = None,
        joint: JointWriter | None = None,
    ) -> None:
        self._joint = joint
        self._coded_writers: Mapping[str, CodedWriter] = coded_writers or _NONE
        self._parse_payload = parse_payload
        self._readers = readers
        self._event_readers: Mapping[str, tuple[Reader[MessageT], ...]] = event_readers or _NONE
        self._writers: Mapping[str, Writer] = writers or _NONE
        topics = "".join(readers)
        self._wild: tuple[str, ...] = ()
        if "+" in topics or "#" in topics:
            self._wild = tuple([topic for topic in readers if "+" in topic or "#" in topic])

    def topics(self) -> tuple[str, ...]:
        """Return its topic filters."""
        return tuple(self._readers)

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return the readings of a message."""
        readers = self._readers.get(topic, ())
        if self._event_readers and not retained:
            readers += self._event_readers.get(topic, ())
        if self._wild:
            matching = tuple(wild for wild in self._wild if topic_matches(wild, topic))
            tables = (self._readers,) if retained else (self._readers, self._event_readers)
            readers += tuple(reader for wild in matching for table in tables for reader in table.get(wild, ()))
        if not readers:
            return NO_READINGS
        message = self._parse_payload(payload)
        if message is None:
            return NO_READINGS
        readings = readers[0](message)
        if len(readers) > 1:
            readings = dict(readings)
            for read in readers[1:]:
                readings.update(read(message))
        return readings

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        """Return the command that sets *capability*."""
        writer = self._writers.get(capability)
        if writer is None:
            raise RefusedError(shown(capability), f"this part takes {', '.join(self._writers) or 'nothing'}")
        return writer(value, require_transition(transition))

    def write_several(
        self, values: Mapping[str, PlainValue], *, transition: float = 0.0
    ) -> tuple[Publications, Collection[str]]:
        """Return the command that sets the first of *values*, and the names of those that it sets."""
        name, value = next(iter(values.items()))
        known = {capability: value for capability, value in values.items() if capability in self._writers}
        if self._joint is None or len(known) < 2 or name not in known:
            return self.write(name, value, transition=transition), (name,)
        return self._joint(self._writers, known, require_transition(transition))

    def write_with_code(self, capability: str, value: PlainValue, code: str) -> Publications:
        """Return the command that sets *capability* with a *code*."""
        if capability not in self._coded_writers:
            raise RefusedError(shown(capability), "it takes no code")
        return self._coded_writers[capability](value, code)

    def moved(self, topics: Mapping[str, str]) -> TableCodec[MessageT]:
        """Return a codec with the same readers and writers on other topics.

        Args:
            topics: The other topics, by those of this codec; no filters.
        """
        readers = dict(zip(map(topics.__getitem__, self._readers), self._readers.values(), strict=True))
        events = self._event_readers
        events = dict(zip(map(topics.__getitem__, events), events.values(), strict=True)) if events else _NONE
        if not self._writers:
            return TableCodec(self._parse_payload, readers, events, _NONE)
        codec = _MovedCodec(self._parse_payload, readers, events, self._writers, self._coded_writers, self._joint)
        codec.moved_topics = topics
        return codec


class _MovedCodec(TableCodec[MessageT]):
    """A codec with the writers of another one, on other topics.

    Attributes:
        moved_topics: The other topics, by those of the writers.
    """

    __slots__ = ("moved_topics",)
    moved_topics: Mapping[str, str]

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> Publications:
        """Return the command that sets *capability*."""
        return self._move(partial(super().write, capability, value, transition=transition))

    def write_several(
        self, values: Mapping[str, PlainValue], *, transition: float = 0.0
    ) -> tuple[Publications, Collection[str]]:
        """Return the command that sets the first of *values*, and the names of those that it sets."""
        names: Collection[str] = ()

        def write() -> Publications:
            nonlocal names
            publications, names = super(_MovedCodec, self).write_several(values, transition=transition)
            return publications

        return self._move(write), names

    def write_with_code(self, capability: str, value: PlainValue, code: str) -> Publications:
        """Return the command that sets *capability* with a *code*."""
        return self._move(partial(super().write_with_code, capability, value, code))

    def _move(self, write: Callable[[], Publications]) -> Publications:
        """Return the publications on its own topics; an error that ends with a topic names its own."""
        try:
            return tuple([publication._replace(topic=self.moved_topics[publication.topic]) for publication in write()])
        except RefusedError as error:
            for other, own in self.moved_topics.items():
                if error.what.endswith(f" {other}"):
                    raise type(error)(f"{error.what.removesuffix(other)}{own}", error.reason, error.code) from None
            raise


_TOPIC = attrgetter("topic")


def is_movable(described: DescribedPart, topics: Iterable[str]) -> bool:
    """Return whether *described* can be moved from *topics* to others: it uses no other ones, and remembers nothing."""
    used = {*described.part.reads, *described.part.writes, *map(_TOPIC, described.state_requests)}
    return not described.remembers and isinstance(described.codec, TableCodec) and used.issubset(topics)


def moved(
    described: DescribedPart, topics: Mapping[str, str], *, part_id: str | None = None, name: str | None = None
) -> DescribedPart:
    """Return a part as the movable one *described*, on other topics.

    Args:
        topics: The other topics, by those of *described*.
        part_id: Its id; by default the same.
        name: Its name; by default the same.
    """
    part, codec = described.part, described.codec
    assert isinstance(codec, TableCodec)  # noqa: S101 - for the type checker
    return DescribedPart(
        part.model_copy(
            update={
                "id": part.id if part_id is None else part_id,
                "name": part.name if name is None else name,
                "reads": tuple(map(topics.__getitem__, part.reads)),
                "writes": tuple(map(topics.__getitem__, part.writes)),
            }
        ),
        codec.moved(topics),
        described.state_requests
        and tuple([request._replace(topic=topics[request.topic]) for request in described.state_requests]),
        described.expiries,
        sends_code=described.sends_code,
    )
