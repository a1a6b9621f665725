"""A part in the making: what one component's config says that it can do, and the codec for it. Pure."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache, partial
from types import MappingProxyType
from typing import TypeAlias

from homebot.devices.part import Capability, Category, Part
from homebot.devices.value import PlainValue
from homebot.errors import RefusedError, WireError
from homebot.gateways.mqtt.description import DescribedPart, Fade, Publication
from homebot.gateways.mqtt.homeassistant.command_topic import CommandTopic
from homebot.gateways.mqtt.homeassistant.config import Config
from homebot.gateways.mqtt.homeassistant.said import Said
from homebot.gateways.mqtt.homeassistant.source import Source
from homebot.gateways.mqtt.payload import clean_text, shown
from homebot.mqtt.topics import topic_matches

__all__ = ["NOTHING", "Entity", "EntityCodec", "Reader", "Readings", "Writer"]

Readings: TypeAlias = Mapping[str, PlainValue]
"""Values by capability; see :meth:`homebot.gateways.mqtt.description.Codec.read`."""

Reader: TypeAlias = Callable[[Said], Readings]
"""What one message on a topic tells."""

Writer: TypeAlias = Callable[[PlainValue, float], tuple[Publication, ...]]
"""What to publish for a value and a transition in seconds; raises RefusedError."""

NOTHING: Readings = MappingProxyType({})

_CATEGORIES: Mapping[str, Category] = {"": "", "config": "config", "diagnostic": "diagnostic"}
_FEW_OPTIONS = 50
_MAX_RAW = 255
_MAX_ID = 255


class EntityCodec:
    """How one part speaks and listens, as tables; see :class:`homebot.gateways.mqtt.description.Codec`."""

    __slots__ = ("_readers", "_wild", "_writers")

    def __init__(self, readers: Mapping[str, tuple[Reader, ...]], writers: Mapping[str, Writer]) -> None:
        self._readers = readers
        self._writers = writers
        self._wild = tuple(topic for topic in readers if "+" in topic or "#" in topic)

    def topics(self) -> tuple[str, ...]:
        """Return the topic filters that it speaks on."""
        return tuple(self._readers)

    def read(self, topic: str, payload: bytes, *, retained: bool) -> Readings:
        """Return what a message tells."""
        readers = self._readers.get(topic, ())
        if self._wild:
            readers += tuple(one for wild in self._wild if topic_matches(wild, topic) for one in self._readers[wild])
        if not readers:
            return NOTHING
        said = Said(payload, retained=retained)
        if len(readers) == 1:
            return readers[0](said)
        found: dict[str, PlainValue] = {}
        for read in readers:
            found.update(read(said))
        return found

    def write(self, capability: str, value: PlainValue, *, transition: float = 0.0) -> tuple[Publication, ...]:
        """Return what to publish so that *capability* becomes *value*."""
        writer = self._writers.get(capability)
        if writer is None:
            known = ", ".join(sorted(self._writers)) or "nothing"
            raise RefusedError(f"{shown(capability)}", f"this part takes {known}")
        return writer(value, transition)


class Entity:
    """Collects what one part can do; a builder's working table.

    Args:
        config: The component's config.
        service_type: See :data:`homebot.devices.device_types.DEVICE_TYPES`.
        tag: What kind it is of its type; by default its ``device_class``.
    """

    def __init__(self, config: Config, service_type: str, tag: str | None = None) -> None:
        self._config = config
        self._service_type = service_type
        self._tag = config.words("device_class") if tag is None else tag
        self._category = _category(config)
        self._capabilities: dict[str, Capability] = {}
        self._readers: dict[str, tuple[Reader, ...]] = {}
        self._writers: dict[str, Writer] = {}
        self._writes: dict[str, None] = {}
        self._fades: tuple[Fade, ...] = ()

    def reads(self, topic: str, reader: Reader) -> None:
        """Read every message on *topic* with *reader*, which never raises."""
        self._readers[topic] = (*self._readers.get(topic, ()), reader)

    def hears(self, source: Source | None, read: Callable[[str], Readings]) -> bool:
        """Read the text at *source* with *read*, which never raises; tell whether it can be read.

        Where the template of the source is not supported, the part shows the payload as ``raw`` instead.
        """
        return source is not None and self.hears_message(source, lambda _said, text: read(text))

    def hears_message(self, source: Source | None, read: Callable[[Said, str], Readings]) -> bool:
        """As :meth:`hears`, but *read* is given the whole message before the text."""
        if source is None:
            return False
        if not source.problem:
            self.reads(source.topic, partial(_read_source, source, read))
            return True
        self.reads(source.topic, partial(_read_raw, source.encoding))
        self.offers("raw")
        return False

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
        make = _capability if len(options) <= _FEW_OPTIONS else _capability.__wrapped__
        self._capabilities[name] = make(name, readable, writer is not None, unit, bounds, options)
        if writer is not None:
            self._writers[name] = writer

    def listens(self, *commands: CommandTopic | None) -> None:
        """Name the topics that the part listens on."""
        self._writes.update((one.topic, None) for one in commands if one is not None)

    def fades(self, *fades: Fade) -> None:
        """Let values end by themselves."""
        self._fades += fades

    def described(self) -> DescribedPart:
        """Return the finished part."""
        config = self._config
        return DescribedPart(
            Part(
                id=clean_text(config.text("unique_id") or config.discovery_id, _MAX_ID),
                name=config.words("name"),
                service_type=self._service_type,
                advertised=config.component,
                tag=self._tag,
                category=self._category,
                capabilities=tuple(self._capabilities.values()),
                reads=tuple(self._readers),
                writes=tuple(self._writes),
            ),
            EntityCodec(self._readers, self._writers),
            fades=self._fades,
        )


@lru_cache(maxsize=512)
def _capability(
    name: str,
    readable: bool,  # noqa: FBT001 - only called above
    settable: bool,  # noqa: FBT001 - only called above
    unit: str,
    bounds: tuple[float, ...],
    options: tuple[str, ...],
) -> Capability:
    """Make a capability, once for all equal ones: the lamps of a house have the same few, and making costs time."""
    return Capability(name=name, readable=readable, settable=settable, unit=unit, bounds=bounds, options=options)


def _category(config: Config) -> Category:
    category = config.text("entity_category")
    if category in _CATEGORIES:
        return _CATEGORIES[category]
    raise WireError(f"{config.component}: entity_category is {shown(category)}, not config or diagnostic")


def _read_source(source: Source, read: Callable[[Said, str], Readings], said: Said) -> Readings:
    text = source.text(said)
    return NOTHING if text is None else read(said, text)


def _read_raw(encoding: str, said: Said) -> Readings:
    text = said.text(encoding)
    return NOTHING if text is None else {"raw": clean_text(text, _MAX_RAW)}
