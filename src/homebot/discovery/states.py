"""Reported states of devices, kept at the announcement through which they came. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from operator import attrgetter

from homebot.devices import State
from homebot.devices.gateway_messages import Reading
from homebot.discovery.entry import Entry
from homebot.discovery.source_record import Reach, SourceRecord, StoredValue
from homebot.messages import Time

__all__ = ["has_capability", "is_denied", "state_of", "store_reachability"]

_NAME = attrgetter("name")


def has_capability(source: SourceRecord, part_id: str, capability: str) -> bool:
    """Return whether a part with that capability was announced."""
    for part in source.sighting.parts:
        if part.id == part_id:
            return capability in map(_NAME, part.capabilities)
    return False


def store_reachability(
    entry: Entry, source: SourceRecord, reading: Reading, stamp: Time, now: float, *, live: bool
) -> None:
    """Note whether a device, or one of its parts, can be reached."""
    if reading.part and all(one.id != reading.part for one in source.sighting.parts):
        return
    value = reading.value.plain()
    answer = value if isinstance(value, bool) else None
    known = source.reach.get(reading.part)
    if known is not None and known.value is answer:
        if known.live is not live:
            known.live = live
            source.set_reach(source.reach)
        return
    source.set_reach({**source.reach, reading.part: Reach(answer, stamp, now, live)})
    entry.is_denied = is_denied(entry.sources.values())


def is_denied(sources: Iterable[SourceRecord]) -> bool:
    """Return whether any of *sources* says that something cannot be reached."""
    denials = [reach for source in sources if source.reach for reach in source.reach.values() if reach.value is False]
    return bool(denials)


def state_of(part_id: str, reading: Reading, stored: StoredValue) -> State:
    """Return the message that tells a value."""
    return State.of_checked(
        part=part_id,
        capability=reading.capability,
        value=reading.value,
        since=stored.since,
        told_at=stored.told_at,
        live=stored.live,
    )
