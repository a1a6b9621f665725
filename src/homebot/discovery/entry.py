"""A device in the index: its announcements, its signs of life, and the message that tells of it."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

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
from homebot.devices.device import OWNER
from homebot.devices.device_types import wanted_types
from homebot.devices.value import PlainValue
from homebot.discovery.endpoints import Addresses, addresses, endpoint_reach, endpoints, last_seen, sorted_routes
from homebot.discovery.liveness import ReportInterval
from homebot.discovery.merging.parts import NO_IDS, MergedParts, PartIds, lost_ids, main_part, merge_parts
from homebot.discovery.merging.trust import NOBODY_TRUSTED, EndpointKey
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.reachability import NOT_REPORTED, offline_parts, reachability
from homebot.discovery.source_record import SourceKey, SourceRecord, StoredValue, preference
from homebot.discovery.topics.ownership import TopicOwnership
from homebot.messages import Time
from homebot.places import NO_AREAS, HousePlan, OwnerFact

if TYPE_CHECKING:
    from homebot.discovery.echoes import Echoes
    from homebot.discovery.merging.agreement import Agreement

__all__ = ["MAX_FACTS", "Entry"]

MAX_FACTS = 200
"""Facts of one device that are published; those of the preferred announcements first."""


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
        published_conflicts: Its conflicts as they were published last.
        topic_owner: The device that keeps a topic from it, as was published last; empty for none.
        silence_allowed: For how many seconds its gateways think that silence is no bad sign.
        saved_at: When it was last to be written to the index file that it was seen, on the clock that is never set.
        known_ids: Ids that parts had, beside those of the description that stands.
        is_denied: Whether any of its announcements says that something of it cannot be reached.
        is_shared: Whether several gateways know it.
        stale_gateways: The gateways at which it was silent for too long, of several that know it.
        trusted: The endpoints that may have its commands, where that was ever a question; those that are gone included.
        claimed: The endpoints that may not; see :mod:`homebot.discovery.merging.trust`.
        agreement: What the two reported lately; None where all are trusted.
        echoes: What happened lately, and by how many routes that was reported; None where nothing happens.
        owner: What the owner states of devices; None before it is in the index.
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
    is_shared: bool = False
    stale_gateways: frozenset[str] = frozenset()
    trusted: frozenset[EndpointKey] = NOBODY_TRUSTED
    claimed: frozenset[EndpointKey] = NOBODY_TRUSTED
    agreement: Agreement | None = None
    echoes: Echoes | None = None
    owner: OwnerFacts | None = None
    _description: _Description | None = None
    _device: Device | None = None

    def best(self) -> SourceRecord:
        """Return the preferred announcement."""
        sources = self.sources.values()
        return next(iter(sources)) if len(sources) == 1 else min(sources, key=preference)

    def hardware(self) -> tuple[str, ...]:
        """Return its hardware addresses."""
        found = (one for source in self._believed().values() for one in source.sighting.identifiers)
        return tuple(dict.fromkeys(one for one in found if not one.startswith("id:")))

    def is_confirmed(self) -> bool:
        """Return whether it was heard itself since the start."""
        return any(source.confirmed for source in self.sources.values())

    def last_seen(self) -> Time:
        """Return when it was last heard of: when it spoke, or else was announced."""
        sources = self.sources.values()
        return next(iter(sources)).seen_at if len(sources) == 1 else last_seen(sources)

    def invalidate_device(self) -> None:
        """Build the device anew when it is next asked for: its states or its freshness changed."""
        self._device = None

    def invalidate_description(self) -> None:
        """Build the description anew when next asked for: its announcements changed, or what is disputed about it."""
        if self._description is not None:
            self.known_ids = self.part_ids()
            self._description = None
        self._device = None

    def part_ids(self) -> PartIds:
        """Return the ids that its parts have, and those that they had in announcements that are gone."""
        if self._description is None:
            return self.known_ids
        ids = self._description.merged.ids()
        return {**self.known_ids, **ids} if self.known_ids else ids

    def parts(self, topics: TopicOwnership) -> MergedParts:
        """Return its parts."""
        described = self._description
        return (self._described(topics) if described is None else described).merged

    def to_device(self, topics: TopicOwnership) -> Device:
        """Return the message that tells all of it; the same object as long as nothing is new."""
        if self._device is None:
            described = self._described(topics)
            sources, has_states, has_events = self.sources.values(), False, False
            for source in sources:
                has_states = has_states or bool(source.values)
                has_events = has_events or bool(source.events)
            parts, reachable = described.merged.parts, self.reachability()
            if self.stale_gateways or self.is_denied:
                parts = sorted_routes(parts, self.sources, self.stale_gateways)
            self._device = Device.of_checked(
                id=self.id,
                name=described.name,
                service_type=described.service_type,
                endpoints=self._endpoints(described.addresses, reachable),
                metadata=described.metadata,
                first_seen=self.first_seen,
                last_seen=self.last_seen(),
                expires=Time.from_seconds(self.expires),
                freshness=self.freshness,
                service_types=described.service_types,
                area=described.area,
                outer_areas=described.outer_areas,
                tags=described.tags,
                names=described.names,
                identifiers=described.identifiers,
                parts=parts,
                facts=described.facts,
                reachable=reachable,
                offline_parts=self.offline_parts(described.merged) if self.is_denied else (),
                states=_states(described.merged, self._newest(described.merged, events=False)) if has_states else (),
                events=_states(described.merged, self._newest(described.merged, events=True)) if has_events else (),
                evidence=self.evidence,
                conflicts=described.merged.conflicts,
            )
        return self._device

    def reachability(self) -> Reachability:
        """Return whether it can be reached, as its parts are together."""
        sources = self._believed().values()
        for source in sources:
            if source.reach:
                return reachability(sources)
        return NOT_REPORTED

    def endpoint_reach(self) -> tuple[str, ...]:
        """Return whether it can be reached at each of its gateways; nothing where there is only one."""
        return endpoint_reach(self.sources) if self.is_shared else ()

    def gateways(self) -> frozenset[str]:
        """Return the gateways that know it."""
        return frozenset(gateway for gateway, _ in self.sources)

    def silent_gateways(self) -> frozenset[str]:
        """Return the gateways at which it has been silent for too long: all of them where it is stale."""
        return self.gateways() if self.freshness == "stale" else self.stale_gateways

    def offline_parts(self, merged: MergedParts) -> tuple[str, ...]:
        """Return the ids of its parts that cannot be reached."""
        if not self.is_denied:
            return ()
        ids = {number: one.id for number, one in enumerate(merged.parts)}
        return offline_parts(self._believed(), merged.places, ids)

    def is_new_event(self, place: int, capability: str, value: PlainValue, route: SourceKey, now: float) -> bool:
        """Return whether an event was not reported by another route already; see :meth:`Echoes.is_new`."""
        if self.echoes is None:
            from homebot.discovery.echoes import Echoes  # noqa: PLC0415 - few devices report events

            self.echoes = Echoes()
        return self.echoes.is_new(place, capability, value, route, now)

    def _endpoints(self, described: tuple[Addresses, ...], reachable: Reachability) -> tuple[Endpoint, ...]:
        """Return its endpoints; the one of a single announcement, as most devices have, is as the device."""
        if len(self.sources) > 1:
            return endpoints(described, self.sources, self.freshness, self.stale_gateways)
        (((gateway, key), address, command_address),) = described
        source, freshness = self.sources[gateway, key], self.freshness
        if gateway in self.stale_gateways:
            freshness = "stale"
        elif freshness == "fresh" and not source.confirmed:
            freshness = "unconfirmed"
        return (
            Endpoint.of_checked(
                gateway=gateway,
                key=key,
                address=address,
                command_address=command_address,
                freshness=freshness,
                last_seen=source.seen_at,
                reachable=reachable.state,
                claimed=source.is_claimed,
            ),
        )

    def _believed(self) -> Mapping[SourceKey, SourceRecord]:
        """Return the announcements by which it is judged what it is, and how: not claimed ones beside others."""
        if not self.claimed:
            return self.sources
        return {key: source for key, source in self.sources.items() if not source.is_claimed} or self.sources

    def _described(self, topics: TopicOwnership) -> _Description:
        if self._description is None:
            sources = tuple(self.sources.values())
            self._description = _describe(sources, topics, self.known_ids, self.owner)
            owner = self.owner
            if owner is not None and not owner.is_empty and (stated := owner.of(self.id, sources)):
                self._description = _with_stated(self._description, stated, owner.plan)
            if self.known_ids:
                self.known_ids = lost_ids(self.known_ids, self._description.merged.places)
        return self._description

    def newest_values(self, topics: TopicOwnership) -> Collection[StoredValue]:
        """Return what is kept of each of :attr:`Device.states`, in their order."""
        return self._newest(self.parts(topics), events=False).values()

    def _newest(self, merged: MergedParts, *, events: bool) -> dict[tuple[int, str], StoredValue]:
        """Return the newest of what all routes to each part reported; what came live before what the broker had kept.

        Args:
            merged: The parts.
            events: Whether to return events rather than values.
        """
        newest: dict[tuple[int, str], StoredValue] = {}
        for (gateway, key), source in self.sources.items():
            for (part, capability), stored in (source.events if events else source.values).items():
                place = merged.places.get((gateway, key, part))
                if place is None or (source.is_claimed and merged.parts[place].routes):
                    continue
                known = newest.get((place, capability))
                if known is None or _weight(stored) > _weight(known):
                    newest[place, capability] = stored
        return newest


@dataclass(slots=True)  # not frozen, which would take a microsecond more for every announcement
class _Description:
    """The part of a record that follows from the announcements, and from what the owner states."""

    name: str
    names: tuple[str, ...]
    service_type: str
    service_types: tuple[str, ...]
    area: str
    identifiers: tuple[str, ...]
    metadata: tuple[KeyValue, ...]
    facts: tuple[Fact, ...]
    addresses: tuple[Addresses, ...]
    merged: MergedParts
    outer_areas: tuple[str, ...]
    tags: tuple[str, ...] = ()


def _describe(
    sources: tuple[SourceRecord, ...], topics: TopicOwnership, known_ids: PartIds, owner: OwnerFacts | None
) -> _Description:
    ordered = sorted(sources, key=preference) if len(sources) > 1 else sources
    merged = merge_parts(ordered, topics, known_ids)
    main = main_part(merged.believed)
    first = ordered[0].sighting
    is_single = len(ordered) == 1
    believed = ordered if is_single else [source for source in ordered if not source.is_claimed] or ordered
    area, outer_areas = first.area if first.area or is_single else _area(believed), NO_AREAS
    if area and owner is not None:
        area, outer_areas = owner.plan.locate(area)
    return _Description(
        name=first.name,
        names=(first.name,) if is_single else tuple(dict.fromkeys(source.sighting.name for source in believed)),
        service_type=first.service_type if main is None or first.is_plain_text else main.part.service_type,
        service_types=_service_types(believed, merged.believed),
        area=area,
        outer_areas=outer_areas,
        identifiers=tuple(dict.fromkeys(first.identifiers)) if is_single else _identifiers(ordered),
        metadata=first.metadata if is_single else _metadata(ordered),
        facts=_facts(ordered),
        addresses=addresses(ordered, main),
        merged=merged,
    )


def _with_stated(described: _Description, stated: tuple[OwnerFact, ...], plan: HousePlan) -> _Description:
    """Return what is announced of a device with what the owner states of it, which outranks that."""
    values = {name: tuple(fact.value for fact in stated if fact.name == name) for name in ("area", "name", "tag")}
    names = tuple(dict.fromkeys((*values["name"], described.name, *described.names)))
    facts = tuple(
        Fact.of_checked(
            name=fact.name,
            value=fact.value,
            gateway="",
            convention=OWNER,
            key=fact.source,
            said_at=Time.from_seconds(fact.said_at),
        )
        for fact in stated
    )
    area, outer_areas = plan.locate(values["area"][0]) if values["area"] else (described.area, described.outer_areas)
    return replace(
        described,
        name=names[0],
        names=names,
        area=area,
        outer_areas=outer_areas,
        tags=values["tag"],
        facts=(*facts, *described.facts)[:MAX_FACTS],
    )


def _states(merged: MergedParts, newest: Mapping[tuple[int, str], StoredValue]) -> tuple[State, ...]:
    return tuple(
        [
            State.of_checked(
                part=merged.parts[place].id,
                capability=capability,
                value=stored.reported,
                since=stored.since,
                told_at=stored.told_at,
                live=stored.live,
            )
            for (place, capability), stored in newest.items()
        ]
    )


def _area(sources: Sequence[SourceRecord]) -> str:
    return next((source.sighting.area for source in sources if source.sighting.area), "")


def _identifiers(sources: Sequence[SourceRecord]) -> tuple[str, ...]:
    found: dict[str, None] = {}
    for source in sources:
        found.update(dict.fromkeys(source.sighting.identifiers))
    return tuple(found)


def _service_types(sources: Sequence[SourceRecord], parts: tuple[DevicePart, ...]) -> tuple[str, ...]:
    if len(parts) == 1:
        part = parts[0].part
        found = [part.service_type, part.advertised] if part.advertised else [part.service_type]
    elif parts:
        shown = [one.part for one in parts if not one.part.category] or [one.part for one in parts]
        found = [one.service_type for one in shown] + [one.advertised for one in shown if one.advertised]
    else:
        words = [one.sighting.service_type for one in sources]
        meant = [wanted_types(one) for one in words]
        found = [min(types) for types in meant if len(types) == 1] + words
    return tuple(dict.fromkeys(found))


def _metadata(sources: Sequence[SourceRecord]) -> tuple[KeyValue, ...]:
    found: dict[str, KeyValue] = {}
    for source in sources:
        for one in source.sighting.metadata:
            found.setdefault(one.key, one)
    return tuple(found.values())[:MAX_FACTS]


def _facts(sources: Sequence[SourceRecord]) -> tuple[Fact, ...]:
    """Return each value once for each gateway and convention, by the first announcement that has it."""
    if len(sources) == 1:
        return tuple(_facts_of(sources[0]))[:MAX_FACTS]
    found: dict[tuple[str, str, str, str], Fact] = {}
    for source in sources:
        for fact in _facts_of(source):
            found.setdefault((fact.name, fact.value, fact.gateway, fact.convention), fact)
        if len(found) >= MAX_FACTS:
            break
    return tuple(found.values())[:MAX_FACTS]


def _facts_of(source: SourceRecord) -> list[Fact]:
    sighting, first_said = source.sighting, source.facts
    gateway, key, convention = sighting.gateway, sighting.key, sighting.convention
    said = {("name", sighting.name): None, ("area", sighting.area): None}
    for one in sighting.metadata:
        said[one.key, one.value] = None
    return [
        Fact.of_checked(
            name=name,
            value=value,
            gateway=gateway,
            convention=convention,
            key=key,
            said_at=first_said[name][1] if name in first_said and first_said[name][0] == value else source.first_seen,
        )
        for name, value in said
        if value
    ]


def _weight(stored: StoredValue) -> tuple[bool, float, int, int]:
    return stored.live, stored.heard_at, stored.told_at.sec, stored.told_at.nanosec
