"""Every announcement that stands, and who reads which topic. Pure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

from homebot.conventions.convention import Convention, TextConvention
from homebot.conventions.description import DeviceAnnounced
from homebot.conventions.text_codec import TextCodec
from homebot.errors import WireError
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.announced.announcement_limits import Excess, MemoryAccount, RegistryLimits, excess_of
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.mqtt.filter_tree import FilterIndex, has_wildcard

__all__ = ["AnnouncementRegistry", "RegistryChange", "TopicReaders"]

_MAX_ROUTES = 50_000

_Readers: TypeAlias = tuple[tuple[str, AnnouncedPart | AvailabilityReader], ...]


_BOUNDS = RegistryLimits()


@dataclass(frozen=True, slots=True)
class TopicReaders:
    """Everybody who reads one topic.

    Attributes:
        conventions: Those that devices announce themselves to there.
        texts: Those that may know who says text there; none as long as one does.
        text: The part that says text there.
        only_text: The same, where nobody else reads the topic.
        availability_readers: Devices whose availability is told there.
        announced_parts: Parts that speak there, those of one device together, but for that one.
    """

    conventions: tuple[Convention, ...]
    texts: tuple[Convention, ...] = ()
    text: AnnouncedPart | None = None
    only_text: AnnouncedPart | None = None
    availability_readers: tuple[AvailabilityReader, ...] = ()
    announced_parts: tuple[AnnouncedPart, ...] = ()


@dataclass(frozen=True, slots=True)
class RegistryChange:
    """The changes that a new description makes.

    Attributes:
        stored: What stands now.
        before: What it took the place of, or None.
        refused: State topics that cannot be read, with the reasons.
        readers: Who reads which topic now that is read by others already, and may have missed what was said there.
    """

    stored: StoredAnnouncement
    before: StoredAnnouncement | None
    refused: tuple[WireError, ...]
    readers: _Readers


class AnnouncementRegistry:
    """The announcements of all conventions of one gateway.

    Args:
        gateway: Its name.
        conventions: The conventions.
        topics: Counts which state topics are needed.
        bounds: How much may stand at once.

    Attributes:
        gateway: Its name.
        by_key: What stands, by key, in the order of its coming.
        codecs: How parts say text, by the topics on which they are told.
        route: Returns who reads a topic; None for nobody.
    """

    def __init__(
        self,
        gateway: str,
        conventions: tuple[Convention, ...],
        topics: StateTopics,
        bounds: RegistryLimits = _BOUNDS,
    ) -> None:
        self.gateway = gateway
        self.codecs: dict[str, TextCodec] = {}
        self._topics = topics
        self._bounds = bounds
        self.by_key: dict[str, StoredAnnouncement] = {}
        self._parts = 0
        self._excess = Excess(bounds.excess, bounds.excess_each)
        self._memory = MemoryAccount(bounds.memory)
        self._announcements: FilterIndex[Convention] = FilterIndex()
        self._text_conventions = frozenset(one for one in conventions if isinstance(one, TextConvention))
        self._texts: dict[str, AnnouncedPart] = {}
        for convention in conventions:
            for topic_filter in convention.filters():
                self._announcements.add(topic_filter, convention)
        self._readers: FilterIndex[AnnouncedPart | AvailabilityReader] = FilterIndex()
        self._reader_counts: dict[str, int] = {}
        self._routes = _Routes(self._find)
        self.route = self._routes.__getitem__

    @property
    def excess(self) -> int:
        """Bytes by which all that stand are longer than what they offer explains."""
        return self._excess.total

    @property
    def memory(self) -> int:
        """Bytes that all that stand take, about."""
        return self._memory.total

    def get(self, key: str) -> StoredAnnouncement | None:
        """Return what stands under *key*."""
        return self.by_key.get(key)

    def all(self) -> tuple[StoredAnnouncement, ...]:
        """Return all that stand, in the order of their coming."""
        return tuple(self.by_key.values())

    def is_read(self, topic: str) -> bool:
        """Return whether a part, or an availability reader, reads *topic* now."""
        return topic in self._texts or bool(self._readers.match(topic))

    def put(self, described: DeviceAnnounced, length: int = 0) -> RegistryChange:
        """Let *described* stand, in place of an earlier one of the same key.

        Args:
            described: The description.
            length: Of the message that it alone was made of; 0 where that is unknown.

        Raises:
            WireError: It has more than 1,000 parts, is one device or part too many, too long, or there is no more
                memory for it. What stood before stays.
        """
        key = described.full_key
        before = self.by_key.get(key)
        self._check_room(described, before)
        excess = excess_of(described, length)
        self._excess.check(described.key, excess, 0 if before is None else before.excess)
        stored = StoredAnnouncement(self.gateway, key, described, excess)
        refused, readers = self._register_readers(stored)
        if described.text is not None:
            self._register_text(stored)
        if before is not None:
            stored.take_over_state(before)
            self._unregister_readers(before)
            readers = _who_missed_something(stored, before, readers)
        self.by_key[key] = stored
        self._parts += len(described.parts)
        self._excess.total += excess
        self._memory.put(described)
        return RegistryChange(stored, before, refused, readers)

    def remove(self, key: str) -> StoredAnnouncement | None:
        """Let what stands under *key* stand no more, and return it."""
        stored = self.by_key.pop(key, None)
        if stored is not None:
            self._unregister_readers(stored)
        return stored

    def __len__(self) -> int:
        return len(self.by_key)

    def _check_room(self, described: DeviceAnnounced, before: StoredAnnouncement | None) -> None:
        if before is not None and before.described.convention != described.convention:
            raise WireError(f"{described.full_key!r} is what {before.described.convention} calls a device already")
        count = len(described.parts)
        if count > self._bounds.parts_each:
            raise WireError(f"{described.key!r} has {count} parts, more than {self._bounds.parts_each:,}")
        if before is None and len(self.by_key) >= self._bounds.announcements:
            raise WireError(
                f"{described.key!r} is one too many: there are {self._bounds.announcements:,} announcements already"
            )
        if self._parts + count - (0 if before is None else len(before.described.parts)) > self._bounds.parts:
            raise WireError(f"{described.key!r} has too many parts: there are {self._bounds.parts:,} parts already")
        self._memory.check(described, None if before is None else before.described)

    def _register_readers(self, stored: StoredAnnouncement) -> tuple[tuple[WireError, ...], _Readers]:
        refused: list[WireError] = []
        readers: list[tuple[str, AnnouncedPart | AvailabilityReader]] = []
        for topic_filter, reader in tuple(_readings(stored)):  # first all, because a plug-in may fail on the way
            count = self._reader_counts.get(topic_filter, 0)
            if count >= self._bounds.readers and isinstance(reader, AnnouncedPart):
                refused.append(WireError(f"topic {topic_filter!r} is read by {self._bounds.readers:,} parts already"))
                continue
            try:
                self._topics.use(topic_filter)
            except WireError as exc:
                refused.append(exc)
                continue
            self._reader_counts[topic_filter] = count + 1
            stored.subscriptions.append((topic_filter, reader))
            self._readers.add(topic_filter, reader)
            self._forget_routes(topic_filter)
            if count and not has_wildcard(topic_filter):
                readers.append((topic_filter, reader))
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

    def _unregister_readers(self, stored: StoredAnnouncement) -> None:
        self._unregister_text(stored)
        self._parts -= len(stored.described.parts)
        self._excess.total -= stored.excess
        self._memory.drop(stored.described)
        for topic_filter, reader in stored.subscriptions:
            self._topics.leave(topic_filter)
            self._readers.remove(topic_filter, reader)
            self._forget_routes(topic_filter)
            if self._reader_counts[topic_filter] == 1:
                del self._reader_counts[topic_filter]
            else:
                self._reader_counts[topic_filter] -= 1

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
                return TopicReaders(conventions, texts)
            route = None
        else:
            availability_readers = tuple(one for one in readers if isinstance(one, AvailabilityReader))
            announced_parts = tuple(one for one in readers if isinstance(one, AnnouncedPart))
            only_text = None if conventions or readers else text
            route = TopicReaders(conventions, texts, text, only_text, availability_readers, announced_parts)
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


def _who_missed_something(stored: StoredAnnouncement, before: StoredAnnouncement, readers: _Readers) -> _Readers:
    if stored.publishes_the_same(before):
        return tuple(
            (topic, reader)
            for topic, reader in readers
            if isinstance(reader, AnnouncedPart) and reader.described.remembers
        )
    return tuple(
        (topic, reader) for topic, reader in readers if isinstance(reader, AnnouncedPart) or _is_new(reader, before)
    )


def _is_new(availability_reader: AvailabilityReader, before: StoredAnnouncement) -> bool:
    return availability_reader.stored.reachability[availability_reader.part] is not before.reachability.get(
        availability_reader.part
    )


def _readings(stored: StoredAnnouncement) -> Iterator[tuple[str, AnnouncedPart | AvailabilityReader]]:
    """Yield each filter that something of *stored* is read on, with what is."""
    for announced_part in stored.parts.values() if stored.described.text is None else ():
        for topic_filter in dict.fromkeys(announced_part.described.codec.topics()):
            yield topic_filter, announced_part
    for part, reachability in stored.reachability.items():
        for index, source in enumerate(reachability.availability.sources):
            yield source.topic, AvailabilityReader(stored, part, index)
