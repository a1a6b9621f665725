"""A part of a device that speaks in JSON objects, in the making: what it can do, and the codec for it. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import lru_cache
from itertools import islice
from types import MappingProxyType
from typing import TypeAlias

from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.mqtt.description import DescribedPart, Fade, Publication
from homebot.gateways.mqtt.payload import MAX_STATE_BYTES, parse_json, shown

__all__ = [
    "NOTHING",
    "JsonCodec",
    "JsonMessage",
    "JsonPart",
    "Reader",
    "Readings",
    "Writer",
    "finite_number",
    "with_own_ids",
]

JsonMessage: TypeAlias = Mapping[str, object]
"""One message: a JSON object. Nobody changes it, because all parts that read it share it."""

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.gateways.mqtt.description.Codec.read`."""

Reader: TypeAlias = Callable[[JsonMessage], Readings]
"""What one message tells; never raises."""

Writer: TypeAlias = Callable[[PlainValue, float], tuple[Publication, ...]]
"""What to publish for a value and a transition in seconds; raises RefusedError."""

NOTHING: Readings = MappingProxyType({})


class JsonCodec:
    """How one part speaks and listens, as tables; see :class:`homebot.gateways.mqtt.description.Codec`."""

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
        """Return the topics that it speaks on."""
        return tuple({**self._readers, **self._event_readers})

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return what a message tells."""
        readers = self._readers.get(topic, ())
        if not retained:
            readers += self._event_readers.get(topic, ())
        message = _parsed(payload) if readers and len(payload) <= MAX_STATE_BYTES else None
        if message is None:
            return NOTHING
        if len(readers) == 1:
            return readers[0](message)
        found: dict[str, PlainValue] = {}
        for read in readers:
            found.update(read(message))
        return found

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        """Return what to publish so that *capability* becomes *value*."""
        writer = self._writers.get(capability)
        if writer is None:
            known = ", ".join(sorted(self._writers)) or "nothing"
            raise RefusedError(shown(capability), f"this part takes {known}")
        return writer(value, transition)


class JsonPart:
    """Collects what one part can do; a builder's working table.

    Args:
        part_id: See :class:`homebot.devices.part.Part`, as are the others.
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
        self._about = (part_id, service_type, name, advertised, tag, category, guessed)
        self._capabilities: dict[str, Capability] = {}
        self._readers: dict[str, tuple[Reader, ...]] = {}
        self._event_readers: dict[str, tuple[Reader, ...]] = {}
        self._writers: dict[str, Writer] = {}
        self._writes: dict[str, None] = {}
        self._asks: dict[Publication, None] = {}
        self._fades: tuple[Fade, ...] = ()

    @property
    def is_empty(self) -> bool:
        """Whether it can do nothing at all."""
        return not self._capabilities

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
        """Have the capability *name*, settable where there is a *writer*. One that is neither is left out."""
        if not readable and writer is None:
            return
        self._capabilities[name] = _capability(name, readable, writer is not None, unit, bounds, options)
        if writer is not None:
            self._writers[name] = writer

    def hears(self, reader: Reader, *topics: str) -> None:
        """Read every message on the *topics* with *reader*."""
        for topic in topics:
            self._readers[topic] = (*self._readers.get(topic, ()), reader)

    def hears_events(self, reader: Reader, *topics: str) -> None:
        """As :meth:`hears`, but what the broker had kept is not read."""
        for topic in topics:
            self._event_readers[topic] = (*self._event_readers.get(topic, ()), reader)

    def listens(self, *topics: str) -> None:
        """Name the topics that the part listens on."""
        self._writes.update(dict.fromkeys(topics))

    def asks(self, *publications: Publication) -> None:
        """Name what makes the device tell the part's state."""
        self._asks.update(dict.fromkeys(publications))

    def fades(self, *fades: Fade) -> None:
        """Let values end by themselves."""
        self._fades += fades

    def described(self) -> DescribedPart:
        """Return the finished part."""
        part_id, service_type, name, advertised, tag, category, guessed = self._about
        codec = JsonCodec(self._readers, self._event_readers, self._writers)
        part = Part(
            id=part_id,
            name=name,
            service_type=service_type,
            advertised=advertised,
            tag=tag,
            category=category,
            guessed=guessed,
            capabilities=tuple(self._capabilities.values()),
            reads=codec.topics(),
            writes=tuple(self._writes),
        )
        return DescribedPart(part, codec, asks=tuple(self._asks), fades=self._fades)


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


def finite_number(value: object) -> float | None:
    """Return *value* where it is a number of a size that devices have; a bool is none."""
    if isinstance(value, (int, float)) and not isinstance(value, bool) and -_HUGE < value < _HUGE:
        return float(value)
    return None


_HUGE = 1e18


@lru_cache(maxsize=2)
def _parsed(payload: bytes) -> JsonMessage | None:
    """All parts of a device read the same message one after the other."""
    try:
        value = parse_json(payload)
    except WireError:
        return None
    return value if isinstance(value, dict) else None


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
