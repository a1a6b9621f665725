"""The topics on which no state is read, as commands with codes go there. Pure."""

from collections.abc import Sequence
from itertools import islice
from typing import TypeAlias

from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.mqtt.reserved import ReservedTopics

__all__ = ["CommandTopics"]

_Reader: TypeAlias = AnnouncedPart | AvailabilityReader


_MOST = 256
"""Most readers of a topic with commands, so that each message is little work."""


class CommandTopics:
    """The command topics of announced parts.

    A topic is read by the first device that takes commands there, and by no other; by none if they may contain a code.
    """

    def __init__(self, reserved: ReservedTopics | None) -> None:
        self._reserved = reserved
        self._parts: dict[str, dict[tuple[str, str], AnnouncedPart]] = {}
        self._coded: dict[str, set[AnnouncedPart]] = {}

    def add(self, part: AnnouncedPart) -> None:
        """Add the command topics of *part*, in the place of an earlier description of it."""
        for topic in part.described.part.writes:
            self._parts.setdefault(topic, {})[_place_of(part)] = part
            if part.described.sends_code:
                self._coded.setdefault(topic, set()).add(part)

    def remove(self, part: AnnouncedPart) -> None:
        """Remove the command topics of *part*."""
        for topic in part.described.part.writes:
            parts, coded = self._parts.get(topic, {}), self._coded.get(topic, set())
            if parts.get(_place_of(part)) is part:
                del parts[_place_of(part)]
            coded.discard(part)
            if not parts:
                self._parts.pop(topic, None)
            if not coded:
                self._coded.pop(topic, None)

    def readable(self, topic: str, readers: Sequence[_Reader]) -> tuple[_Reader, ...]:
        """Return those of *readers* that may read what is published on *topic*."""
        if not readers or topic in self._coded or (self._reserved is not None and self._reserved.is_secret(topic)):
            return ()
        if (parts := self._parts.get(topic)) is None:
            return tuple(readers)
        names = _names_of(next(iter(parts.values())).stored)
        return tuple(islice((one for one in readers if _is_of(one, names)), _MOST))


def _place_of(part: AnnouncedPart) -> tuple[str, str]:
    return part.stored.key, part.described.part.id


def _is_of(reader: _Reader, names: frozenset[str]) -> bool:
    """Return whether *reader* belongs to a device with one of *names*."""
    if isinstance(reader, AnnouncedPart):
        return not names.isdisjoint(_names_of(reader.stored))
    return any(not names.isdisjoint(_names_of(one)) for one, _ in reader.reachability.members)


def _names_of(stored: StoredAnnouncement) -> frozenset[str]:
    """Return the names of a device, one of which its announcements share."""
    return frozenset((stored.key, *stored.described.identifiers))
