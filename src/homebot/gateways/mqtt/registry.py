"""The announcements registered at an MQTT gateway, and the readers of each topic. Pure."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import NamedTuple, TypeAlias

from homebot.conventions.convention import Convention, TextConvention
from homebot.conventions.text_codec import TextCodec
from homebot.errors import WireError
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.announced.registry import DeviceRegistry, Readers, RegistryLimits
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.mqtt.filter_tree import FilterIndex, has_wildcard

__all__ = ["AnnouncementRegistry", "TopicReaders"]

_MAX_ROUTES = 50_000
_MAX_GROUPS = 64
"""Groups of conventions that find announcements on the same topics: few, however many topics there are."""


_FEW_PARTS = 100
"""Parts that may read one message in one go."""

_BOUNDS = RegistryLimits()

_Readings: TypeAlias = list[tuple[str, AnnouncedPart | AvailabilityReader]]
"""Filters, each with its reader."""


class TopicReaders(NamedTuple):
    """All readers of one topic.

    Attributes:
        conventions: Those that devices announce themselves to there.
        texts: Those that may know the part of a text there; none as long as one does.
        text: The part that says text there.
        only_text: The same, if the topic has no other reader.
        availability_readers: Devices with availability there.
        announced_parts: Parts that speak there, those of one device together, but for that one.
        only_states: Whether nothing is there but the states of those parts, which are few.
    """

    conventions: tuple[Convention, ...]
    texts: tuple[Convention, ...] = ()
    text: AnnouncedPart | None = None
    only_text: AnnouncedPart | None = None
    availability_readers: tuple[AvailabilityReader, ...] = ()
    announced_parts: tuple[AnnouncedPart, ...] = ()
    only_states: bool = False


class AnnouncementRegistry(DeviceRegistry):
    """The announcements of all conventions of one gateway.

    Args:
        gateway: Its name.
        conventions: The conventions.
        topics: Counts which state topics are needed.
        bounds: How much may stand at once.

    Attributes:
        codecs: How parts say text, by the topics on which they are told.
        route: Returns the readers of a topic; None if it has none.
    """

    def __init__(
        self,
        gateway: str,
        conventions: tuple[Convention, ...],
        topics: StateTopics,
        bounds: RegistryLimits = _BOUNDS,
    ) -> None:
        super().__init__(gateway, bounds)
        self.codecs: dict[str, TextCodec] = {}
        self._topics = topics
        self._announcements: FilterIndex[Convention] = FilterIndex()
        self._text_conventions = frozenset(one for one in conventions if isinstance(one, TextConvention))
        self._texts: dict[str, AnnouncedPart] = {}
        for convention in conventions:
            for topic_filter in convention.filters():
                self._announcements.add(topic_filter, convention)
        self._readers: FilterIndex[AnnouncedPart | AvailabilityReader] = FilterIndex()
        self._announcement_readers = lru_cache(_MAX_GROUPS)(TopicReaders)
        self._routes = _Routes(self._find)
        self.route = self._routes.__getitem__

    def is_read(self, topic: str) -> bool:
        """Return whether a part, or an availability reader, reads *topic* now."""
        return topic in self._texts or self._readers.has_match(topic)

    def _enter(
        self, stored: StoredAnnouncement, before: StoredAnnouncement | None
    ) -> tuple[tuple[WireError, ...], Readers]:
        refused: list[WireError] = []
        readers: _Readings = []
        for topic_filter, reader in _readings(stored):
            count = self._topics.users.get(topic_filter, 0)
            if count >= self._limits.readers and isinstance(reader, AnnouncedPart):
                refused.append(
                    WireError(f"topic {topic_filter!r} already has {self._limits.readers:,} readers, the limit")
                )
                continue
            try:
                self._topics.use(topic_filter)
            except WireError as exc:
                refused.append(exc)
                continue
            stored.subscriptions.append((topic_filter, reader))
            self._readers.add(topic_filter, reader)
            self._forget_routes(topic_filter)
            if count and not has_wildcard(topic_filter):
                readers.append((topic_filter, reader))
        if stored.described.text is not None:
            self._register_text(stored)
        if before is not None and readers:
            readers = _readers_to_replay(stored, before, readers)
        return tuple(refused), tuple(readers)

    def _register_text(self, stored: StoredAnnouncement) -> None:
        """Register a text device; its convention's filters bring its messages, so it needs no subscription."""
        if (text := stored.described.text) is not None:
            for announced_part in stored.parts.values():
                self._texts[text.address] = announced_part
                if isinstance(announced_part.described.codec, TextCodec):
                    self.codecs[text.command_address] = announced_part.described.codec
            self._forget_routes(text.address)

    def _unregister_text(self, stored: StoredAnnouncement) -> None:
        text = stored.described.text
        if text is not None and self._texts.get(text.address) in stored.parts.values():
            del self._texts[text.address]
            self.codecs.pop(text.command_address, None)
            self._forget_routes(text.address)

    def _leave(self, stored: StoredAnnouncement) -> None:
        self._unregister_text(stored)
        for topic_filter, reader in stored.subscriptions:
            self._topics.leave(topic_filter)
            self._readers.remove(topic_filter, reader)
            self._forget_routes(topic_filter)

    def _forget_routes(self, topic_filter: str) -> None:
        if "+" in topic_filter or "#" in topic_filter:
            self._routes.clear()
        else:
            self._routes.pop(topic_filter, None)

    def _find(self, topic: str) -> TopicReaders | None:
        conventions = self._announcements.match(topic)
        readers = self._readers.match(topic)
        text = self._texts.get(topic)
        texts: tuple[Convention, ...] = ()
        if not self._text_conventions.isdisjoint(conventions):
            if text is None:
                texts = tuple(one for one in conventions if one in self._text_conventions)
            conventions = tuple(one for one in conventions if one not in self._text_conventions)
        if not readers and text is None:  # announcements are many, and few of them come again
            if conventions or texts:
                return self._announcement_readers(conventions, texts)
            route = None
        else:
            availability_readers = tuple(one for one in readers if isinstance(one, AvailabilityReader))
            announced_parts = tuple(one for one in readers if isinstance(one, AnnouncedPart))
            only_text = None if conventions or readers else text
            others = conventions or texts or text or availability_readers
            only_states = not others and len(announced_parts) <= _FEW_PARTS
            route = TopicReaders(
                conventions, texts, text, only_text, availability_readers, announced_parts, only_states
            )
        if len(self._routes) >= _MAX_ROUTES:
            self._routes.clear()
        self._routes[topic] = route
        return route


class _Routes(dict[str, TopicReaders | None]):
    """Readers by topic, found where they are first asked for: a topic that was asked for before costs no call."""

    def __init__(self, find: Callable[[str], TopicReaders | None]) -> None:
        super().__init__()
        self._find = find

    def __missing__(self, topic: str) -> TopicReaders | None:
        return self._find(topic)


def _readers_to_replay(stored: StoredAnnouncement, before: StoredAnnouncement, readers: _Readings) -> _Readings:
    if stored.publishes_the_same(before):
        return [one for one in readers if isinstance(one[1], AnnouncedPart) and one[1].described.remembers]
    return [one for one in readers if isinstance(one[1], AnnouncedPart) or _is_new(one[1], before)]


def _is_new(reader: AvailabilityReader, before: StoredAnnouncement) -> bool:
    return reader.stored.reachability[reader.part] is not before.reachability.get(reader.part)


def _readings(stored: StoredAnnouncement) -> _Readings:
    """Return each filter with a reader of *stored*; all at once, as a plug-in may fail."""
    found: _Readings = []
    for announced_part in stored.parts.values() if stored.described.text is None else ():
        for topic_filter in dict.fromkeys(announced_part.described.codec.topics()):
            found.append((topic_filter, announced_part))  # a list for each part costs more
    for part, reachability in stored.reachability.items():
        for index, source in enumerate(reachability.availability.sources):
            found.append((source.topic, AvailabilityReader(stored, part, index)))
    return found
