"""The topics on which no state is read, as commands with codes go there. Pure."""

from collections.abc import Iterable
from typing import TypeAlias

from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement
from homebot.gateways.mqtt.reserved import ReservedTopics

__all__ = ["CommandTopics"]

_Reader: TypeAlias = AnnouncedPart | AvailabilityReader


class CommandTopics:
    """The command topics of announced parts.

    A topic is read by the device that takes commands there, unless they may contain a code, and by no other.
    """

    def __init__(self, reserved: ReservedTopics | None) -> None:
        self._reserved = reserved
        self._parts: dict[str, tuple[AnnouncedPart, ...]] = {}

    def add(self, part: AnnouncedPart) -> None:
        """Add the command topics of *part*."""
        for topic in part.described.part.writes:
            self._parts[topic] = (*self._parts.get(topic, ()), part)

    def remove(self, part: AnnouncedPart) -> None:
        """Remove the command topics of *part*."""
        for topic in part.described.part.writes:
            if left := tuple([one for one in self._parts.get(topic, ()) if one is not part]):
                self._parts[topic] = left
            else:
                self._parts.pop(topic, None)

    def may_read(self, topic: str, reader: _Reader) -> bool:
        """Return whether *reader* may read what is published on *topic*."""
        if self._reserved is not None and self._reserved.is_secret(topic):
            return False
        parts = self._parts.get(topic, ())
        own = (reader.stored,) if isinstance(reader, AnnouncedPart) else [one for one, _ in reader.reachability.members]
        return not any(one.described.sends_code or not _is_one_device(one.stored, own) for one in parts)

    def readable(self, topic: str, readers: Iterable[_Reader]) -> tuple[_Reader, ...]:
        """Return those of *readers* that may read *topic*."""
        return tuple([one for one in readers if self.may_read(topic, one)])


def _is_one_device(stored: StoredAnnouncement, others: Iterable[StoredAnnouncement]) -> bool:
    own = stored.described.identifiers
    return any(one.key == stored.key or not set(own).isdisjoint(one.described.identifiers) for one in others)
