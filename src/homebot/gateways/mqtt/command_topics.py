"""The topics on which no state is read, as commands with codes go there. Pure."""

from collections.abc import Sequence
from typing import TypeAlias

from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.mqtt.reserved import ReservedTopics

__all__ = ["CommandTopics"]

_Reader: TypeAlias = AnnouncedPart | AvailabilityReader


_MOST = 256
"""Most parts with commands on a topic that is read, so that each message is little work."""


class CommandTopics:
    """The command topics of announced parts.

    A topic is read by the device that takes commands there, unless they may contain a code, and by no other.
    """

    def __init__(self, reserved: ReservedTopics | None) -> None:
        self._reserved = reserved
        self._parts: dict[str, dict[AnnouncedPart, None]] = {}

    def add(self, part: AnnouncedPart) -> None:
        """Add the command topics of *part*."""
        for topic in part.described.part.writes:
            self._parts.setdefault(topic, {})[part] = None

    def remove(self, part: AnnouncedPart) -> None:
        """Remove the command topics of *part*."""
        for topic in part.described.part.writes:
            if parts := self._parts.get(topic):
                parts.pop(part, None)
                if not parts:
                    del self._parts[topic]

    def readable(self, topic: str, readers: Sequence[_Reader]) -> tuple[_Reader, ...]:
        """Return those of *readers* that may read what is published on *topic*."""
        if not readers or (self._reserved is not None and self._reserved.is_secret(topic)):
            return ()
        if (parts := self._parts.get(topic)) is None:
            return tuple(readers)
        if len(parts) > _MOST or any(one.described.sends_code for one in parts):
            return ()
        names = frozenset.intersection(*[_names_of(one.stored) for one in parts])
        return tuple([one for one in readers if _is_of(one, names)])


def _is_of(reader: _Reader, names: frozenset[str]) -> bool:
    """Return whether *reader* belongs to a device with one of *names*."""
    if isinstance(reader, AnnouncedPart):
        return not names.isdisjoint(_names_of(reader.stored))
    return any(not names.isdisjoint(_names_of(one)) for one, _ in reader.reachability.members)


def _names_of(stored: StoredAnnouncement) -> frozenset[str]:
    """Return the names of a device, one of which its announcements share."""
    return frozenset((stored.key, *stored.described.identifiers))
