"""A device in the index: its announcements, its signs of life, and its message."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TYPE_CHECKING, final

from homebot.devices import (
    Device,
    Endpoint,
    Fact,
    Freshness,
    Reachability,
    State,
)
from homebot.devices.echoes import Echoes
from homebot.discovery.description import (
    MAX_FACTS,
    DeviceDescription,
    describe_device,
    with_approvals,
    with_doubts,
    with_panel,
    with_preferred_routes,
    with_stated_facts,
    without_parts_of,
)
from homebot.discovery.endpoints import (
    NOT_REPORTED,
    Addresses,
    endpoint_reach,
    endpoints,
    last_seen,
    offline_parts,
    reachability,
    routes_without,
    silent_strangers,
    sorted_routes,
)
from homebot.discovery.merging.part_ids import NO_IDS, PartIds, lost_ids
from homebot.discovery.merging.parts import MergedParts
from homebot.discovery.merging.trust import NOBODY_TRUSTED, Agreement, EndpointKey
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.search.columns import StoredValue
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.discovery.topics.ownership import TopicOwnership
from homebot.messages import Time

if TYPE_CHECKING:
    from homebot.discovery.groups import HouseGroups

# Looked up once, as `of_checked` says.
_device_of, _endpoint_of, _state_of = Device.of_checked, Endpoint.of_checked, State.of_checked
_stamp_of = Time.from_seconds
_VALUES, _EVENTS, _UNREADABLE = attrgetter("values"), attrgetter("events"), attrgetter("unreadable")

_MAX_GAPS = 8

_BURST = 1.0
"""Seconds within which messages belong together, as devices often send several at once."""

_MIN_GAPS = 3

_SILENCE_FACTOR = 3.0
"""Usual gaps that silence may last: two reports may be lost on the way."""

_MAX_FIRST_SILENCE_S = 86_400.0

_MAX_INTERVAL_S = 7 * 86_400.0


@final
@dataclass(slots=True, eq=False)
class ReportInterval:
    """The gaps between the last reports of a device: at most eight, so that old habits are forgotten.

    From three gaps on the longest one is ignored, as it may have been a power cut.

    Attributes:
        gaps: The gaps in seconds, oldest first.
        expected_silence: Seconds of silence that are usual after a report; 0 if unknown.
    """

    gaps: tuple[float, ...] = ()
    expected_silence: float = 0.0
    _last: float | None = None

    @classmethod
    def of(cls, gaps: Iterable[float]) -> ReportInterval:
        """Return the interval that these *gaps* of an earlier run show."""
        known = tuple(gaps)[-_MAX_GAPS:]
        return cls(known, _usual_silence(known))

    def record(self, now: float) -> float:
        """Record a report at *now*, in seconds; return the expected silence after it."""
        last = self._last
        if last is None:
            self._last = now
        elif (gap := now - last) >= _BURST:
            self._last = now
            self._learn((*self.gaps, gap)[-_MAX_GAPS:])
        return self.expected_silence

    def join(self, other: ReportInterval) -> None:
        """Copy the interval that *other* has learnt about the same device, if it is longer."""
        if len(other.gaps) > len(self.gaps):
            self._learn(other.gaps)
        if other._last is not None:
            self._last = max(other._last, self._last or other._last)

    def _learn(self, gaps: tuple[float, ...]) -> None:
        self.gaps = gaps
        self.expected_silence = _usual_silence(gaps)


def _usual_silence(gaps: tuple[float, ...]) -> float:
    if not gaps:
        return 0.0
    if len(gaps) < _MIN_GAPS:
        return min(_SILENCE_FACTOR * min(gaps), _MAX_FIRST_SILENCE_S)
    return min(_SILENCE_FACTOR * sorted(gaps)[-2], _MAX_INTERVAL_S)


@dataclass(slots=True, eq=False)
class Entry:
    """The index's record of a device.

    Attributes:
        deadline: When it becomes stale unless it reports again, on the monotonic clock.
        expires: The same in seconds since the Unix epoch.
        evidence: Why its announcements describe one device, in words.
        doubts: The identifiers that another device of its gateway claims as well, in words.
        topic_owner: The device that claims one of its topics, as last published; empty for none.
        silence_allowed: Seconds of silence that its gateways consider normal.
        saved_period: The period of the monotonic clock in which its last sighting was last queued for saving.
        known_ids: Former ids of parts, in addition to those of the current description.
        is_denied: Whether any of its announcements reports a part, or all of it, as unreachable.
        is_shared: Whether several gateways know it.
        stale_gateways: Of several gateways, those at which it has been silent for too long.
        trusted: The endpoints that may get its commands, once that had to be decided; also those that are gone.
        claimed: The endpoints that may not get them; see :mod:`homebot.discovery.merging.trust`.
        agreement: The last reports of trusted and claimed endpoints; None if all are trusted.
        echoes: The last events, with the number of routes that reported each; None without events.
        owner: The owner's statements; None before it is in the index.
        panel: The identifier of the alarm panel on which it hangs; empty for none.
        device: The last result of :meth:`to_device`; None if states or freshness have changed since.
    """

    id: str
    first_seen: Time
    freshness: Freshness
    sources: dict[SourceKey, SourceRecord] = field(default_factory=dict)
    deadline: float = -math.inf
    expires: float = 0.0
    report_interval: ReportInterval = field(default_factory=ReportInterval)
    evidence: tuple[str, ...] = ()
    saved_period: float = -math.inf
    silence_allowed: float = 0.0
    published_conflicts: tuple[str, ...] = ()
    doubts: tuple[str, ...] = ()
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
    panel: str = ""
    _description: DeviceDescription | None = None
    device: Device | None = None

    def hardware(self) -> tuple[str, ...]:
        """Return the hardware addresses of the device."""
        identifiers = (identifier for source in self._believed().values() for identifier in source.sighting.identifiers)
        return tuple(dict.fromkeys(identifier for identifier in identifiers if not identifier.startswith("id:")))

    def last_seen(self) -> Time:
        """Return when it was last seen: when it last reported, or else was announced."""
        sources = self.sources.values()
        return next(iter(sources)).seen_at if len(sources) == 1 else last_seen(sources)

    def invalidate_description(self) -> None:
        """Discard the description, because its announcements or the disputes about it have changed."""
        if self._description is not None:
            self.known_ids = self.part_ids()
            self._description = None
        self.device = None

    def part_ids(self) -> PartIds:
        """Return the ids of its parts, including those from announcements that are gone."""
        if self._description is None:
            return self.known_ids
        ids = self._description.merged.ids()
        return {**self.known_ids, **ids} if self.known_ids else ids

    def parts(self, topics: TopicOwnership) -> MergedParts:
        """Return its parts."""
        return (self._description or self._describe(topics)).merged

    def to_device(self, topics: TopicOwnership) -> Device:
        """Return the message that describes it; the same object as long as nothing has changed."""
        if self.device is None:
            described = self._description or self._describe(topics)
            sources = self.sources.values()
            has_states, has_events = any(map(_VALUES, sources)), any(map(_EVENTS, sources))
            facts = described.facts
            if any(map(_UNREADABLE, sources)):
                facts = _add_unreadable(facts, sources)
            parts, reachable = described.merged.parts, self.reachability()
            conflicts = described.merged.conflicts
            _, *others = sources  # without a call, as this runs for every announcement
            strangers = silent_strangers(self.sources, topics.denied) if others else None
            if strangers:
                parts, conflicts = routes_without(parts, strangers), (*conflicts, *filter(None, strangers.values()))
            if self.stale_gateways or self.is_denied:
                parts = sorted_routes(parts, self.sources, self.stale_gateways)
            self.device = _device_of(
                id=self.id,
                name=described.name,
                service_type=described.service_type,
                endpoints=self._endpoints(described.addresses, reachable),
                metadata=described.metadata,
                first_seen=self.first_seen,
                last_seen=self.last_seen(),
                expires=_stamp_of(self.expires),
                freshness=self.freshness,
                service_types=described.service_types,
                area=described.area,
                outer_areas=described.outer_areas,
                tags=described.tags,
                names=described.names,
                identifiers=described.identifiers,
                parts=parts,
                facts=facts,
                reachable=reachable,
                offline_parts=self.offline_parts(described.merged) if self.is_denied else (),
                states=_states(described.merged, self._newest(described.merged, events=False)) if has_states else (),
                events=_states(described.merged, self._newest(described.merged, events=True)) if has_events else (),
                evidence=self.evidence,
                conflicts=conflicts,
            )
            if strangers:
                self.device = without_parts_of(strangers, self.device, described.merged)
            if self.owner is not None and self.owner.groups is not None:
                self.device = self._in_groups(self.device, described, self.owner.groups)
        return self.device

    @staticmethod
    def _in_groups(device: Device, described: DeviceDescription, groups: HouseGroups) -> Device:
        if described.groups is None:
            described.groups = groups.facts_of(device)
        facts = (*described.groups, *device.facts)[:MAX_FACTS]
        return device.model_copy(update={"facts": facts}) if described.groups else device

    def is_regrouped(self, groups: HouseGroups, topics: TopicOwnership) -> bool:
        """Return whether the gateways' groups of which it is a member changed; its message is discarded then."""
        device = self.to_device(topics)
        described = self._description or self._describe(topics)
        if groups.native_facts(device) == tuple([group for group in described.groups or () if not group.convention]):
            return False
        described.groups = self.device = None
        return True

    def reachability(self) -> Reachability:
        """Return whether it can be reached, combined from its parts."""
        sources = self._believed() if self.claimed else self.sources
        for source in sources.values():
            if source.reach or source.lost is not None:
                return reachability(sources.values())
        return NOT_REPORTED

    def reach_state(self) -> str:
        """Return the state of :meth:`reachability`, faster if nothing of it is unreachable."""
        for source in self._believed().values():
            for reach in source.reach.values():
                if reach.value and not source.is_lost:
                    return "yes"
        return self.reachability().state

    def endpoint_reach(self) -> tuple[str, ...]:
        """Return for each gateway whether it can be reached there; nothing if there is only one."""
        return endpoint_reach(self.sources) if self.is_shared else ()

    def gateways(self) -> frozenset[str]:
        """Return the gateways that know it."""
        return frozenset(gateway for gateway, _ in self.sources)

    def silent_gateways(self) -> frozenset[str]:
        """Return the gateways at which it has been silent for too long; all of them if it is stale."""
        return self.gateways() if self.freshness == "stale" else self.stale_gateways

    def offline_parts(self, merged: MergedParts) -> tuple[str, ...]:
        """Return the ids of its parts that cannot be reached."""
        if not self.is_denied:
            return ()
        ids = {number: part.id for number, part in enumerate(merged.parts)}
        return offline_parts(self._believed(), merged.places, ids)

    def _endpoints(self, described: tuple[Addresses, ...], reachable: Reachability) -> tuple[Endpoint, ...]:
        """Return its endpoints; a single announcement, as most devices have, shares the state of the device."""
        if len(self.sources) > 1:
            return endpoints(described, self.sources, self.freshness, self.stale_gateways)
        (((gateway, key), address, command_address),) = described
        source, freshness = self.sources[gateway, key], self.freshness
        if gateway in self.stale_gateways:
            freshness = "stale"
        elif freshness == "fresh" and not source.confirmed:
            freshness = "unconfirmed"
        return (
            _endpoint_of(
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
        """Return the announcements that decide its type and state: those not merely claimed, if there are any."""
        if not self.claimed:
            return self.sources
        return {key: source for key, source in self.sources.items() if not source.is_claimed} or self.sources

    def _describe(self, topics: TopicOwnership) -> DeviceDescription:
        if self._description is None:
            sources = tuple(self.sources.values())
            self._description = describe_device(sources, topics, self.known_ids, self.owner)
            if self.doubts:
                self._description = with_doubts(self._description, self.doubts)
            owner = self.owner
            if owner is not None and owner.prefer:
                self._description = with_preferred_routes(self._description, owner.prefer, owner.read_at)
            if owner is not None and not owner.is_empty:
                if stated := owner.of(self.id, sources):
                    self._description = with_stated_facts(self._description, stated, owner.plan)
                self._description = with_approvals(self._description, owner.approvals.of_device(sources))
            if self.panel:
                self._description = with_panel(self._description, self.panel, self.first_seen)
            if self.known_ids:
                self.known_ids = lost_ids(self.known_ids, self._description.merged.places)
        return self._description

    def newest_values(self, topics: TopicOwnership) -> Collection[StoredValue]:
        """Return the stored value of each of :attr:`Device.states`, in their order."""
        return self._newest(self.parts(topics), events=False).values()

    def _newest(self, merged: MergedParts, *, events: bool) -> dict[tuple[int, str], StoredValue]:
        """Return the newest report of each part by any route; live values take precedence over retained ones."""
        newest: dict[tuple[int, str], StoredValue] = {}
        for (gateway, key), source in self.sources.items():
            for (part, capability), stored in (source.events if events else source.values).items():
                number = merged.places.get(place := (gateway, key, part))
                if number is None or place in merged.hidden:
                    continue
                known = newest.get((number, capability))
                if known is None or _weight(stored) > _weight(known):
                    newest[number, capability] = stored
        return newest


def silent_gateways(entries: Iterable[Entry]) -> frozenset[str]:
    """Return the gateways at which none of *entries* reported in time."""
    heard, silent = set[str](), set[str]()
    for entry in entries:
        silent |= entry.silent_gateways()
        heard |= entry.gateways() - entry.silent_gateways()
    return frozenset(silent - heard)


def _add_unreadable(facts: tuple[Fact, ...], sources: Iterable[SourceRecord]) -> tuple[Fact, ...]:
    """Return *facts* after those of *sources* that sent what could not be read."""
    return (*[fact for source in sources for fact in source.unreadable.values()], *facts)[:MAX_FACTS]


def _states(merged: MergedParts, newest: Mapping[tuple[int, str], StoredValue]) -> tuple[State, ...]:
    return tuple(
        [
            _state_of(
                part=merged.parts[place].id,
                capability=capability,
                value=stored.reported,
                since=stored.since,
                told_at=stored.told_at,
                live=stored.live,
                is_first=stored.is_first,
            )
            for (place, capability), stored in newest.items()
        ]
    )


def _weight(stored: StoredValue) -> tuple[bool, float, int, int]:
    return stored.live, stored.heard_at, stored.told_at.sec, stored.told_at.nanosec
