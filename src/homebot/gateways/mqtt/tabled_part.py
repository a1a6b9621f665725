"""A part in the making whose codec is two tables: what each topic tells, and how each capability is told. Pure."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import lru_cache
from types import MappingProxyType
from typing import TypeAlias

from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.mqtt.description import DescribedPart, Publication
from homebot.gateways.mqtt.payload import MAX_STATE_BYTES, parse_json, shown

__all__ = [
    "NOTHING",
    "Reader",
    "Readings",
    "TabledPart",
    "Writer",
    "json_in",
    "number_in",
    "text_in",
]

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.gateways.mqtt.description.Codec.read`."""

Reader: TypeAlias = Callable[[bytes], Readings]
"""What a payload tells. Never raises."""

Writer: TypeAlias = Callable[[PlainValue, float], tuple[Publication, ...]]
"""What to publish for a value and a transition in seconds; raises RefusedError."""

NOTHING: Readings = MappingProxyType({})


class TabledPart:
    """Collects what one part can do.

    Args:
        part_id: See :attr:`Part.id`.
        service_type: See :attr:`Part.service_type`.
        name: See :attr:`Part.name`.
        advertised: See :attr:`Part.advertised`.
        tag: See :attr:`Part.tag`.
        category: See :attr:`Part.category`.
        guessed: See :attr:`Part.guessed`.
    """

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
        self.service_type = service_type
        self.tag = tag
        self.guessed = guessed
        self._part_id = part_id
        self._name = name
        self._advertised = advertised
        self._category = category
        self._capabilities: dict[str, Capability] = {}
        self._readers: dict[str, tuple[Reader, ...]] = {}
        self._event_readers: dict[str, tuple[Reader, ...]] = {}
        self._writers: dict[str, Writer] = {}
        self._writes: dict[str, None] = {}

    @property
    def can(self) -> frozenset[str]:
        """Names of its capabilities so far."""
        return frozenset(self._capabilities)

    def reads(self, topic: str, reader: Reader) -> None:
        """Read every message on *topic* with *reader*."""
        self._readers[topic] = (*self._readers.get(topic, ()), reader)

    def reads_events(self, topic: str, reader: Reader) -> None:
        """Read every message on *topic* with *reader*, but those that the broker had kept: they happened before."""
        self._readers.setdefault(topic, ())
        self._event_readers[topic] = (*self._event_readers.get(topic, ()), reader)

    def offers(
        self,
        name: str,
        *,
        readable: bool = True,
        writer: Writer | None = None,
        unit: str = "",
        bounds: tuple[float, ...] = (),
        options: tuple[str, ...] = (),
    ) -> None:
        """Have the capability *name*, settable where there is a *writer*."""
        self._capabilities[name] = _capability(name, readable, writer is not None, unit, bounds, options)
        if writer is not None:
            self._writers[name] = writer

    def listens(self, topic: str) -> None:
        """Name a topic that the part listens on."""
        self._writes[topic] = None

    def described(self, asks: tuple[Publication, ...] = ()) -> DescribedPart:
        """Return the finished part."""
        part = Part(
            id=self._part_id,
            name=self._name,
            service_type=self.service_type,
            advertised=self._advertised,
            tag=self.tag,
            category=self._category,
            guessed=self.guessed,
            capabilities=tuple(self._capabilities.values()),
            reads=tuple(self._readers),
            writes=tuple(self._writes),
        )
        return DescribedPart(part, _TableCodec(self._readers, self._event_readers, self._writers), asks)


class _TableCodec:
    """See :class:`homebot.gateways.mqtt.description.Codec`."""

    __slots__ = ("_event_readers", "_readers", "_writers")

    def __init__(
        self,
        readers: Mapping[str, tuple[Reader, ...]],
        event_readers: Mapping[str, tuple[Reader, ...]],
        writers: Mapping[str, Writer],
    ) -> None:
        self._readers = readers
        self._event_readers = event_readers
        self._writers = writers

    def topics(self) -> tuple[str, ...]:
        return tuple(self._readers)

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        readers = self._readers.get(topic, ())
        if not retained and topic in self._event_readers:
            readers += self._event_readers[topic]
        if len(readers) == 1:
            return readers[0](payload)
        found: dict[str, PlainValue] = {}
        for read in readers:
            found.update(read(payload))
        return found

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        writer = self._writers.get(capability)
        if writer is None:
            known = ", ".join(sorted(self._writers)) or "no commands"
            raise RefusedError(shown(capability), f"this part takes {known}")
        if not (math.isfinite(transition) and transition >= 0):
            raise RefusedError(f"transition {shown(transition)}", "it takes seconds from 0")
        return writer(value, transition)


@lru_cache(maxsize=8)
def text_in(payload: bytes) -> str | None:
    """Return the text that *payload* is; None where it is none, or longer than what is looked at."""
    if len(payload) > MAX_STATE_BYTES:
        return None
    try:
        return payload.decode()
    except UnicodeDecodeError:
        return None


@lru_cache(maxsize=2)  # all parts of a device read the same message, one after the other
def json_in(payload: bytes) -> object:
    """Return what *payload* says in JSON, not to be changed; None where that is nothing."""
    try:
        return parse_json(payload)
    except WireError:
        return None


def number_in(value: object) -> float | None:
    """Return the finite number that *value* is, or that a text spells; None where there is none."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)):
        return None
    if isinstance(value, str) and (len(value) > _LONGEST_NUMBER or not value.isascii() or "_" in value):
        return None
    try:
        number = float(value)
    except (ValueError, OverflowError):
        return None
    return number if math.isfinite(number) else None


_LONGEST_NUMBER = 40


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
