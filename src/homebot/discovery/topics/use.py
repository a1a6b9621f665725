"""The use that an announcement makes of topics: where it sends, reads, and what is its own. Pure."""

from __future__ import annotations

from typing import NamedTuple

from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.discovery.topics.places import names, place_of, score

__all__ = ["TopicUse", "topic_use"]


class TopicUse(NamedTuple):
    """The topics that one announcement uses.

    Attributes:
        key: The announcement.
        device: Whose it is.
        announced_on: Where it was made.
        writes: Its command topics.
        reads: Its state topics.
        owns: Topics that the device has for itself, with all that is below them.
        identifiers: Who the device is, where it has such topics.
        bridge: The bridge that the device is behind.
        is_anonymous: Whether it does not say who the device is.
        is_native: Whether it is in a convention of devices themselves.
    """

    key: SourceKey
    device: str
    announced_on: str = ""
    writes: tuple[str, ...] = ()
    reads: tuple[str, ...] = ()
    owns: tuple[str, ...] = ()
    identifiers: tuple[str, ...] = ()
    bridge: str = ""
    is_anonymous: bool = False
    is_native: bool = False

    def has(self, topic: str) -> bool:
        """Return whether *topic* is the device's own."""
        return any(topic == prefix or topic.startswith(f"{prefix}/") for prefix in self.owns)

    def rank(self, topic: str) -> int:
        """Return how well the place of the announcement names *topic*."""
        return score(place_of(self.announced_on), topic)

    def names(self) -> frozenset[str]:
        """By which names announcements at other places may be the same device's."""
        return names(place_of(self.announced_on))


def topic_use(source: SourceRecord, device: str) -> TopicUse:
    """Return what the announcement *source* of *device* does with topics."""
    sighting = source.sighting
    parts = sighting.parts
    if len(parts) == 1:
        writes, reads = _once(parts[0].writes), _once(parts[0].reads)
    else:
        writes = tuple(dict.fromkeys([topic for part in parts for topic in part.writes]))
        reads = tuple(dict.fromkeys([topic for part in parts for topic in part.reads]))
    if sighting.command_address and sighting.speaks_plainly:
        writes = _once((*writes, sighting.command_address))
    bridge = ""
    for fact in sighting.metadata:
        if fact.key == "via_device":
            bridge = fact.value
            break
    return TopicUse(
        source.key,
        device,
        sighting.announced_on,
        writes,
        reads,
        sighting.owns,
        sighting.identifiers if sighting.owns else (),
        bridge,
        not sighting.identifiers,
        sighting.native,
    )


def _once(topics: tuple[str, ...]) -> tuple[str, ...]:
    # The same object takes no memory.
    return topics if len(topics) < 2 else tuple(dict.fromkeys(topics))
