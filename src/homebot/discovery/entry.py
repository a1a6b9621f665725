"""A device in the index: its announcements, its signs of life, and the message that tells of it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from homebot.devices import (
    Device,
    DevicePart,
    Endpoint,
    Fact,
    Freshness,
    KeyValue,
    Reachability,
    State,
)
from homebot.devices.device_types import wanted_types
from homebot.devices.text.encode import accepts_text, text_address
from homebot.devices.value import PlainValue, Value
from homebot.discovery.command_topics import TopicOwnership
from homebot.discovery.echoes import Echoes
from homebot.discovery.merging.part_ids import NO_IDS, PartIds, lost_ids
from homebot.discovery.merging.parts import MergedParts, main_part, merge_parts
from homebot.discovery.reachability import offline_parts, reachability
from homebot.discovery.report_interval import ReportInterval
from homebot.discovery.source_record import SourceKey, SourceRecord, StoredValue, preference
from homebot.messages import Time

__all__ = ["MAX_FACTS", "Entry"]

MAX_FACTS = 200
"""Facts of one device that are told; those of the preferred announcements first."""


@dataclass(slots=True, eq=False)
class Entry:
    """The index's record of a device.

    Attributes:
        id: Its id, for as long as the entry lives.
        sources: Its announcements by gateway and key.
        first_seen: When it was first heard of.
        freshness: See :class:`Device`.
        deadline: When it becomes stale unless it is heard of again, in seconds of the clock that is never set.
        expires: The same in seconds since the Unix epoch.
        report_interval: How often it speaks.
        evidence: Why its announcements are one device, in words.
        published_conflicts: What was last told to be disputed about it.
        topic_owner: The device that keeps a topic from it, as was last told; empty for none.
        silence_allowed: For how many seconds its gateways think that silence is no bad sign.
        saved_at: When it was last to be written to the index file that it was seen, on the clock that is never set.
        known_ids: Ids that parts had, beside those of the description that stands.
        is_denied: Whether any of its announcements says that something of it cannot be reached.
        echoes: What happened lately, and by how many routes that was told; None where nothing happens.
    """

    id: str
    first_seen: Time
    freshness: Freshness
    sources: dict[SourceKey, SourceRecord] = field(default_factory=dict)
    deadline: float = -math.inf
    expires: float = 0.0
    report_interval: ReportInterval = field(default_factory=ReportInterval)
    evidence: tuple[str, ...] = ()
    saved_at: float = -math.inf
    silence_allowed: float = 0.0
    published_conflicts: tuple[str, ...] = ()
    topic_owner: str = ""
    known_ids: PartIds = field(default_factory=lambda: NO_IDS)
    is_denied: bool = False
    echoes: Echoes | None = None
    _description: _Description | None = None
    _device: Device | None = None

    def best(self) -> SourceRecord:
        """Return the preferred announcement."""
        claims = self.sources.values()
        return next(iter(claims)) if len(claims) == 1 else min(claims, key=preference)

    def hardware(self) -> tuple[str, ...]:
        """Return its hardware addresses."""
        found = (one for claim in self.sources.values() for one in claim.sighting.identifiers)
        return tuple(dict.fromkeys(one for one in found if not one.startswith("id:")))

    def is_confirmed(self) -> bool:
        """Return whether it was heard itself since the start."""
        return any(claim.confirmed for claim in self.sources.values())

    def last_seen(self) -> Time:
        """Return when it was last heard of: when it spoke, or else was announced."""
        if len(self.sources) == 1:
            return self.best().seen_at
        confirmed = [claim for claim in self.sources.values() if claim.confirmed]
        return max(confirmed or self.sources.values(), key=lambda one: (one.heard_at, _moment(one.seen_at))).seen_at

    def invalidate_device(self) -> None:
        """Its states or its freshness changed."""
        self._device = None

    def invalidate_description(self) -> None:
        """Its announcements changed, or what is disputed about it."""
        self.known_ids = self.part_ids()
        self._device = self._description = None

    def part_ids(self) -> PartIds:
        """Return the ids that its parts have, and those that they had in announcements that are gone."""
        if self._description is None:
            return self.known_ids
        ids = self._description.merged.ids()
        return {**self.known_ids, **ids} if self.known_ids else ids

    def parts(self, topics: TopicOwnership) -> MergedParts:
        """Return its parts."""
        return self._described(topics).merged

    def to_device(self, topics: TopicOwnership) -> Device:
        """Return the message that tells all of it; the same object as long as nothing is new."""
        if self._device is None:
            described = self._described(topics)
            self._device = Device.of_checked(
                id=self.id,
                name=described.name,
                service_type=described.service_type,
                endpoints=described.endpoints,
                metadata=described.metadata,
                first_seen=self.first_seen,
                last_seen=self.last_seen(),
                expires=Time.from_seconds(self.expires),
                freshness=self.freshness,
                service_types=described.service_types,
                area=described.area,
                names=described.names,
                identifiers=described.identifiers,
                parts=described.merged.parts,
                facts=described.facts,
                reachable=self.reachability(),
                offline_parts=self.offline_parts(described.merged),
                states=self._newest(described.merged, [claim.values for claim in self.sources.values()]),
                events=self._newest(described.merged, [claim.events for claim in self.sources.values()]),
                evidence=self.evidence,
                conflicts=described.merged.conflicts,
            )
        return self._device

    def reachability(self) -> Reachability:
        """Return whether it can be reached, as its parts are together."""
        return reachability(self.sources.values())

    def offline_parts(self, merged: MergedParts) -> tuple[str, ...]:
        """Return the ids of its parts that cannot be reached."""
        if not self.is_denied:
            return ()
        return offline_parts(self.sources, merged.places, {number: one.id for number, one in enumerate(merged.parts)})

    def is_new_event(self, place: int, capability: str, value: PlainValue, route: SourceKey, now: float) -> bool:
        """Return whether an event was not told by another route already; see :meth:`Echoes.is_new`."""
        if self.echoes is None:
            self.echoes = Echoes()
        return self.echoes.is_new(place, capability, value, route, now)

    def _described(self, topics: TopicOwnership) -> _Description:
        if self._description is None:
            self._description = _describe(tuple(self.sources.values()), topics, self.known_ids)
            if self.known_ids:
                self.known_ids = lost_ids(self.known_ids, self._description.merged.places)
        return self._description

    def _newest(self, merged: MergedParts, said: Sequence[Mapping[tuple[str, str], StoredValue]]) -> tuple[State, ...]:
        """The newest of what all routes to a part told; what came live counts more than what the broker had kept.

        Args:
            merged: The parts.
            said: What each of the announcements told.
        """
        if not any(said):
            return ()
        newest: dict[tuple[int, str], StoredValue] = {}
        for (gateway, key), values in zip(self.sources, said, strict=True):
            for (part, capability), told in values.items():
                place = merged.places.get((gateway, key, part))
                if place is None:
                    continue
                known = newest.get((place, capability))
                if known is None or _weight(told) > _weight(known):
                    newest[place, capability] = told
        return tuple(
            [
                State.of_checked(
                    part=merged.parts[place].id,
                    capability=capability,
                    value=Value.of(told.value),
                    since=told.since,
                    told_at=told.told_at,
                    live=told.live,
                )
                for (place, capability), told in newest.items()
            ]
        )


@dataclass(frozen=True, slots=True)
class _Description:
    """The part of a record that follows from the announcements alone."""

    name: str
    names: tuple[str, ...]
    service_type: str
    service_types: tuple[str, ...]
    area: str
    identifiers: tuple[str, ...]
    metadata: tuple[KeyValue, ...]
    facts: tuple[Fact, ...]
    endpoints: tuple[Endpoint, ...]
    merged: MergedParts


def _describe(claims: tuple[SourceRecord, ...], topics: TopicOwnership, known_ids: PartIds) -> _Description:
    ordered = sorted(claims, key=preference) if len(claims) > 1 else claims
    merged = merge_parts(ordered, topics, known_ids)
    main = main_part(merged.parts)
    names = tuple(dict.fromkeys(one.sighting.name for one in ordered))
    first = ordered[0].sighting
    return _Description(
        name=names[0],
        names=names,
        service_type=first.service_type if main is None or first.speaks_plainly else main.part.service_type,
        service_types=_service_types(ordered, merged.parts),
        area=next((one.sighting.area for one in ordered if one.sighting.area), ""),
        identifiers=tuple(dict.fromkeys(found for one in ordered for found in one.sighting.identifiers)),
        metadata=first.metadata if len(ordered) == 1 else _metadata(ordered),
        facts=_facts(ordered),
        endpoints=_endpoints(ordered, main),
        merged=merged,
    )


def _service_types(claims: Sequence[SourceRecord], parts: tuple[DevicePart, ...]) -> tuple[str, ...]:
    if parts:
        shown = [one.part for one in parts if not one.part.category] or [one.part for one in parts]
        found = [one.service_type for one in shown] + [one.advertised for one in shown if one.advertised]
    else:
        words = [one.sighting.service_type for one in claims]
        meant = [wanted_types(one) for one in words]
        found = [min(types) for types in meant if len(types) == 1] + words
    return tuple(dict.fromkeys(found))


def _metadata(claims: Sequence[SourceRecord]) -> tuple[KeyValue, ...]:
    found: dict[str, KeyValue] = {}
    for claim in claims:
        for one in claim.sighting.metadata:
            found.setdefault(one.key, one)
    return tuple(found.values())[:MAX_FACTS]


def _facts(claims: Sequence[SourceRecord]) -> tuple[Fact, ...]:
    """Each value once for each gateway and convention, by the first announcement that says it."""
    found: dict[tuple[str, str, str, str], Fact] = {}
    for claim in claims:
        gateway, key, convention = claim.sighting.gateway, claim.sighting.key, claim.sighting.convention
        for name, value in _said(claim):
            place = (name, value, gateway, convention)
            if not value or place in found:
                continue
            said_at = claim.first_seen
            if name in claim.facts and claim.facts[name][0] == value:
                said_at = claim.facts[name][1]
            found[place] = Fact.of_checked(
                name=name, value=value, gateway=gateway, convention=convention, key=key, said_at=said_at
            )
            if len(found) >= MAX_FACTS:
                return tuple(found.values())
    return tuple(found.values())


def _said(claim: SourceRecord) -> list[tuple[str, str]]:
    sighting = claim.sighting
    return [("name", sighting.name), ("area", sighting.area), *((one.key, one.value) for one in sighting.metadata)]


def _endpoints(claims: Sequence[SourceRecord], main: DevicePart | None) -> tuple[Endpoint, ...]:
    """One for each gateway: two conventions at one gateway say everything twice."""
    found: dict[str, Endpoint] = {}
    if main is not None:
        said = {claim.key: claim.sighting for claim in claims}
        for route in main.routes:
            sighting = said[route.gateway, route.key]
            if sighting.speaks_plainly:
                address, command_address = sighting.address, sighting.command_address
            else:
                address = text_address(route.key, route.part)
                command_address = _told_at(main, route.gateway)
            endpoint = Endpoint.of_checked(
                gateway=route.gateway, key=route.key, address=address, command_address=command_address
            )
            found.setdefault(route.gateway, endpoint)
    for claim in claims if not found else ():
        sighting = claim.sighting
        if sighting.gateway not in found:
            found[sighting.gateway] = Endpoint.of_checked(
                gateway=sighting.gateway,
                key=sighting.key,
                address=sighting.address,
                command_address="" if main is not None else sighting.command_address,
            )
    return tuple(found.values())


def _told_at(part: DevicePart, gateway: str) -> str:
    """Return where *part* takes text: by the first of the gateway's ways that takes any."""
    ways = (one for one in part.routes if one.gateway == gateway and one.takes) if accepts_text(part.part) else ()
    return next((text_address(one.key, one.part) for one in ways), "")


def _moment(time: Time | None) -> tuple[int, int]:
    return (time.sec, time.nanosec) if time is not None else (0, 0)


def _weight(told: StoredValue) -> tuple[bool, float, int, int]:
    return told.live, told.heard, told.told_at.sec, told.told_at.nanosec
