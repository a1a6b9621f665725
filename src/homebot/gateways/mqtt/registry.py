"""The registered announcements of an MQTT gateway, and the readers of each topic. Pure."""

import math
from collections.abc import Callable, Hashable, Iterable, Sequence
from functools import lru_cache
from itertools import islice
from typing import NamedTuple, TypeAlias

from homebot.conventions.convention import Convention, TextConvention
from homebot.conventions.description import Availability, TextEndpoint
from homebot.conventions.text_codec import TextCodec
from homebot.devices.part import CommandDescription
from homebot.errors import WireError
from homebot.gateways.announced.announcement import (
    AnnouncedPart,
    AvailabilityReader,
    SharedReachability,
    StoredAnnouncement,
)
from homebot.gateways.announced.registry import DeviceRegistry, Readers, RegistryLimits
from homebot.gateways.mqtt.reserved import ReservedTopics
from homebot.gateways.mqtt.state_topics import StateTopics
from homebot.mqtt.filter_tree import FilterIndex, has_wildcard

_MAX_ROUTES = 50_000
_MAX_GROUPS = 64
"""Distinct sets of conventions that share topics: few, however many topics there are."""

_BOUNDS = RegistryLimits()

_Readings: TypeAlias = list[tuple[str, AnnouncedPart | AvailabilityReader]]
"""Filters, each with a reader."""


_Reader: TypeAlias = AnnouncedPart | AvailabilityReader

_MAX_READERS = 256
"""Most readers of a topic with commands, so that each message is little work."""


class CommandTopics:
    """The command topics of announced parts.

    A topic is read by the first device that takes commands there, and by those whose state it was before. If the
    commands may contain a code, it is read by these alone, and by nobody once the owner approved them.
    """

    def __init__(self, reserved: ReservedTopics | None) -> None:
        self._reserved = reserved
        self._parts: dict[str, dict[tuple[str, str], AnnouncedPart]] = {}
        self._coded: FilterIndex[AnnouncedPart] = FilterIndex()
        self.approved: frozenset[str] = frozenset()

    def add(self, part: AnnouncedPart) -> tuple[str, ...]:
        """Add the command topics of *part*, in place of its earlier description; return the filters concerned."""
        for topic in part.described.part.writes:
            self._parts.setdefault(topic, {})[part.stored.key, part.described.part.id] = part
        for topic_filter in (filters := _coded_filters(part) if part.described.sends_code else ()):
            self._coded.add(topic_filter, part)
        return *part.described.part.writes, *filters

    def remove(self, part: AnnouncedPart) -> tuple[str, ...]:
        """Remove the command topics of *part*; return the filters concerned."""
        place = part.stored.key, part.described.part.id
        for topic in part.described.part.writes:
            if (parts := self._parts.get(topic)) and parts.get(place) is part:
                del parts[place]
                if not parts:
                    del self._parts[topic]
        for topic_filter in (filters := _coded_filters(part) if part.described.sends_code else ()):
            self._coded.remove(topic_filter, part)
        return *part.described.part.writes, *filters

    def readable(self, topic: str, readers: Sequence[_Reader]) -> tuple[_Reader, ...]:
        """Return those of *readers* that may read what is published on *topic*."""
        if not readers or (self._reserved and self._reserved.is_secret(topic)):
            return ()
        coded = self._coded.match(topic)
        if coded:
            if any(self._is_approved(part) for part in coded):
                return ()
            return tuple(reader for reader in readers if all(_is_before(reader, part, topic) for part in coded))
        if (parts := self._parts.get(topic)) is None:
            return tuple(readers)
        first = next(iter(parts.values()))
        names = _names_of(first.stored)
        return tuple(
            islice(
                (reader for reader in readers if _is_of(reader, names) or _is_before(reader, first, topic)),
                _MAX_READERS,
            )
        )

    def _is_approved(self, part: AnnouncedPart) -> bool:
        described = CommandDescription.of(part.described.part, part.stored.described.identifiers)
        return bool(self.approved) and described.digest in self.approved


def _coded_filters(part: AnnouncedPart) -> tuple[str, ...]:
    """Return the filters of topics with codes of *part*: Zigbee2MQTT takes them on ``LOCK/set/pin_code`` too."""
    return tuple([f"{topic}/#" if topic.endswith("/set") else topic for topic in part.described.part.writes])


def _is_before(reader: _Reader, part: AnnouncedPart, topic: str) -> bool:
    """Return whether *reader* was announced before *part* takes commands on *topic*: who comes later may be a spy.

    A topic that is called one of commands is that of *part*, and a reader with wildcards comes later. Those that were
    both retained count as equally old.
    """
    if topic.rpartition("/")[2].casefold() in _OF_COMMANDS:
        return False
    if isinstance(reader, AnnouncedPart):
        members, filters = [reader.stored], reader.described.part.reads
    else:
        members = [member for member, _ in reader.reachability.members]
        filters = (reader.reachability.availability.sources[reader.index].topic,)
    since = min((member.since for member in members), default=math.inf) if topic in filters else math.inf
    return since < part.stored.since or since == 0


_OF_COMMANDS = frozenset({"cmd", "cmnd", "code", "command", "commands", "in", "pin_code", "set"})


def _is_of(reader: _Reader, names: frozenset[str]) -> bool:
    """Return whether *reader* belongs to a device with one of *names*."""
    if isinstance(reader, AnnouncedPart):
        return not names.isdisjoint(_names_of(reader.stored))
    return any(not names.isdisjoint(_names_of(member)) for member, _ in reader.reachability.members)


def _names_of(stored: StoredAnnouncement) -> frozenset[str]:
    """Return the names of a device, one of which its announcements share."""
    return frozenset((stored.key, *stored.described.identifiers))


class TopicReaders(NamedTuple):
    """All readers of one topic.

    Attributes:
        conventions: Conventions that read announcements there.
        texts: Conventions that may recognize a text there; empty once its part is known.
        text: The part that publishes text there.
        only_text: The same part, if the topic has no other reader.
        availability_readers: Readers of availability there.
        announced_parts: Parts that read their state there, grouped by device; without *text*.
        only_states: Whether the only readers are those parts.
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

    Attributes:
        codecs: The codecs of parts that publish text, by their command topics.
        commands: The topics of commands.
        route: Returns the readers of a topic, or None.
    """

    def __init__(
        self,
        gateway: str,
        conventions: tuple[Convention, ...],
        topics: StateTopics,
        bounds: RegistryLimits = _BOUNDS,
        reserved: ReservedTopics | None = None,
    ) -> None:
        super().__init__(gateway, bounds)
        self.commands = CommandTopics(reserved)
        self.codecs: dict[str, TextCodec] = {}
        self._topics = topics
        self._announcements: FilterIndex[Convention] = FilterIndex()
        self._text_conventions = frozenset(
            convention for convention in conventions if isinstance(convention, TextConvention)
        )
        self._texts: dict[str, AnnouncedPart] = {}
        for convention in conventions:
            for topic_filter in convention.filters():
                self._announcements.add(topic_filter, convention)
        self._readers: FilterIndex[AnnouncedPart | AvailabilityReader] = FilterIndex()
        self._shared: dict[Hashable, SharedReachability] = {}
        self._announcement_readers = lru_cache(_MAX_GROUPS)(TopicReaders)
        self._routes = _Routes(self._find)
        self.route = self._routes.__getitem__

    def set_approved(self, digests: Iterable[str]) -> None:
        """Read nothing more where approved commands may contain codes: those with *digests*."""
        self.commands.approved = frozenset(digests)
        self._routes.clear()

    def is_read(self, topic: str) -> bool:
        """Return whether a part or an availability reader reads *topic*."""
        return topic in self._texts or self._readers.has_match(topic)

    def _enter(
        self, stored: StoredAnnouncement, before: StoredAnnouncement | None
    ) -> tuple[tuple[WireError, ...], Readers]:
        refused: list[WireError] = []
        replayed: _Readings = []
        only_remembering = before is not None and stored.publishes_the_same(before)
        availabilities = _availabilities(stored)
        for topic_filter, part in _read_topics(stored):
            count = self._topics.users.get(topic_filter, 0)
            if count >= self._limits.readers:
                refused.append(
                    WireError(f"topic {topic_filter!r} already has {self._limits.readers:,} readers, the limit")
                )
                continue
            if not self._add_reader(topic_filter, part, refused):
                continue
            part.filters = (*part.filters, topic_filter)
            if not self.commands.readable(topic_filter, (part,)):
                refused.append(WireError(f"commands of another device, or codes, go to {topic_filter!r}"))
            elif count and not has_wildcard(topic_filter) and (part.described.remembers or not only_remembering):
                replayed.append((topic_filter, part))
        reachability: dict[str, SharedReachability] = {}
        for part_id, availability, key, topics in availabilities:
            shared = reachability[part_id] = self._shared_reachability(availability, key, topics, refused, replayed)
            shared.members.append((stored, part_id))
        stored.reachability = reachability or stored.reachability
        for part in stored.parts.values():
            self._forget_routes(*self.commands.add(part))
        if stored.described.text is not None:
            self._register_text(stored, stored.described.text)
        return tuple(refused), tuple(replayed)

    def _shared_reachability(
        self,
        availability: Availability,
        key: Hashable,
        topics: Iterable[str],
        refused: list[WireError],
        replayed: _Readings,
    ) -> SharedReachability:
        """Return the reachability under *key*, or a new one that reads the *topics* of its *availability*."""
        shared = self._shared.get(key)
        if shared is not None:
            return shared
        shared = self._shared[key] = SharedReachability(availability)
        for index, topic_filter in enumerate(topics):
            is_known = topic_filter in self._topics.users and not has_wildcard(topic_filter)
            reader = AvailabilityReader(shared, index)
            if self._add_reader(topic_filter, reader, refused):
                shared.subscriptions.append((topic_filter, reader))
                if is_known:
                    replayed.append((topic_filter, reader))
        return shared

    def _add_reader(
        self, topic_filter: str, reader: AnnouncedPart | AvailabilityReader, refused: list[WireError]
    ) -> bool:
        """Add *reader*; if the filter cannot be used, add the reason to *refused* and return False."""
        try:
            self._topics.use(topic_filter)
        except WireError as exc:
            refused.append(exc)
            return False
        self._readers.add(topic_filter, reader)
        self._forget_routes(topic_filter)
        return True

    def _remove_reader(self, topic_filter: str, reader: AnnouncedPart | AvailabilityReader) -> None:
        self._topics.leave(topic_filter)
        self._readers.remove(topic_filter, reader)
        self._forget_routes(topic_filter)

    def _register_text(self, stored: StoredAnnouncement, text: TextEndpoint) -> None:
        """Register a text device; the filters of its convention already cover its messages."""
        for announced_part in stored.parts.values():
            self._texts[text.address] = announced_part
            if isinstance(announced_part.described.codec, TextCodec):
                self.codecs[text.command_address] = announced_part.described.codec
        self._forget_routes(text.address)

    def _leave(self, stored: StoredAnnouncement) -> None:
        for part in stored.parts.values():
            self._forget_routes(*self.commands.remove(part))
            for topic_filter in part.filters:
                self._remove_reader(topic_filter, part)
        text = stored.described.text
        if text is not None and self._texts.get(text.address) in stored.parts.values():
            del self._texts[text.address]
            self.codecs.pop(text.command_address, None)
            self._forget_routes(text.address)
        for part_id, shared in stored.reachability.items():
            shared.members.remove((stored, part_id))
            if not shared.members:
                del self._shared[_shared_key(stored, shared.availability)]
                for state_filter, reader in shared.subscriptions:
                    self._remove_reader(state_filter, reader)

    def _forget_routes(self, *topic_filters: str) -> None:
        for topic_filter in topic_filters:
            if "+" in topic_filter or "#" in topic_filter:
                self._routes.clear()
            else:
                self._routes.pop(topic_filter, None)

    def _find(self, topic: str) -> TopicReaders | None:
        conventions = self._announcements.match(topic)
        readers = self.commands.readable(topic, self._readers.match(topic))
        text = self._texts.get(topic)
        texts: tuple[Convention, ...] = ()
        if not self._text_conventions.isdisjoint(conventions):
            if text is None:
                texts = tuple(convention for convention in conventions if convention in self._text_conventions)
            conventions = tuple(convention for convention in conventions if convention not in self._text_conventions)
        if not readers and text is None and (conventions or texts):
            return self._announcement_readers(conventions, texts)  # most announcements come only once
        if len(self._routes) >= _MAX_ROUTES:
            self._routes.clear()
        route = self._routes[topic] = _route_of(conventions, texts, text, readers)
        return route


def _route_of(
    conventions: tuple[Convention, ...],
    texts: tuple[Convention, ...],
    text: AnnouncedPart | None,
    readers: Sequence[AnnouncedPart | AvailabilityReader],
) -> TopicReaders | None:
    if not readers and text is None:
        return None
    availability_readers = tuple(reader for reader in readers if isinstance(reader, AvailabilityReader))
    announced_parts = tuple(reader for reader in readers if isinstance(reader, AnnouncedPart))
    only_text = None if conventions or readers else text
    only_states = not any((conventions, texts, text, availability_readers))
    return TopicReaders(conventions, texts, text, only_text, availability_readers, announced_parts, only_states)


class _Routes(dict[str, TopicReaders | None]):
    """A cache of readers by topic, without a function call for a known topic."""

    def __init__(self, find: Callable[[str], TopicReaders | None]) -> None:
        super().__init__()
        self._find = find

    def __missing__(self, topic: str) -> TopicReaders | None:
        return self._find(topic)


def _shared_key(stored: StoredAnnouncement, availability: Availability) -> Hashable:
    """Return the key under which *availability* is shared: with its device, or its announcement if that names none."""
    device = stored.described.identifiers or stored.key
    try:
        hash(availability)
    except TypeError:  # of a plug-in
        return device, id(availability)
    return device, availability


def _read_topics(stored: StoredAnnouncement) -> list[tuple[str, AnnouncedPart]]:
    """Return each topic that a part of *stored* reads, with the part; a list, so that a plug-in fails early."""
    parts = stored.parts.values() if stored.described.text is None else ()
    return [(topic, part) for part in parts for topic in dict.fromkeys(part.described.codec.topics())]


def _availabilities(stored: StoredAnnouncement) -> list[tuple[str, Availability, Hashable, list[str]]]:
    """Return each availability of *stored* with its part, key and topics; a list, so that a plug-in fails early."""
    availabilities: list[tuple[str, Availability, Hashable, list[str]]] = []
    described = stored.described
    own = {"": described.availability}
    for part in described.parts:
        if part.availability is not None:
            own[part.part.id] = part.availability
    for part_id, availability in own.items():
        if availability is not None and availability.sources:
            topics = [source.topic for source in availability.sources]
            availabilities.append((part_id, availability, _shared_key(stored, availability), topics))
    return availabilities
