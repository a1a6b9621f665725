"""The topics of commands: by which device each is read, and which are not, as codes may go there. Pure."""

import math
from collections.abc import Sequence
from itertools import islice
from typing import TypeAlias

from homebot.devices.part import CommandDescription
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.mqtt.reserved import ReservedTopics
from homebot.mqtt.filter_tree import FilterIndex

_Reader: TypeAlias = AnnouncedPart | AvailabilityReader

_MOST = 256
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
            if any(self._is_approved(one) for one in coded):
                return ()
            return tuple(one for one in readers if all(_is_before(one, part, topic) for part in coded))
        if (parts := self._parts.get(topic)) is None:
            return tuple(readers)
        first = next(iter(parts.values()))
        names = _names_of(first.stored)
        return tuple(islice((one for one in readers if _is_of(one, names) or _is_before(one, first, topic)), _MOST))

    def _is_approved(self, part: AnnouncedPart) -> bool:
        described = CommandDescription.of(part.described.part, part.stored.described.identifiers)
        return bool(self.approved) and described.digest in self.approved


def _coded_filters(part: AnnouncedPart) -> tuple[str, ...]:
    """Return the filters of topics with codes of *part*: Zigbee2MQTT takes them on ``LOCK/set/pin_code`` too."""
    return tuple([f"{one}/#" if one.endswith("/set") else one for one in part.described.part.writes])


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
        members = [one for one, _ in reader.reachability.members]
        filters = (reader.reachability.availability.sources[reader.index].topic,)
    since = min((one.since for one in members), default=math.inf) if topic in filters else math.inf
    return since < part.stored.since or since == 0


_OF_COMMANDS = frozenset({"cmd", "cmnd", "code", "command", "commands", "in", "pin_code", "set"})


def _is_of(reader: _Reader, names: frozenset[str]) -> bool:
    """Return whether *reader* belongs to a device with one of *names*."""
    if isinstance(reader, AnnouncedPart):
        return not names.isdisjoint(_names_of(reader.stored))
    return any(not names.isdisjoint(_names_of(one)) for one, _ in reader.reachability.members)


def _names_of(stored: StoredAnnouncement) -> frozenset[str]:
    """Return the names of a device, one of which its announcements share."""
    return frozenset((stored.key, *stored.described.identifiers))
