"""The devices that announcements describe: they appear, merge, split and go with them. Pure."""

import math
from collections.abc import Container, Iterable, Iterator, Mapping
from operator import attrgetter
from typing import Final, NamedTuple, final

from homebot.devices.identity import identifiers
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry, silent_gateways
from homebot.discovery.ids import Tombstone, new_id
from homebot.discovery.liveness import Liveness
from homebot.discovery.merging.decisions import OWNER, MergeDecisions
from homebot.discovery.merging.identity import REPEATED, IdentityGraph
from homebot.discovery.merging.part_ids import NO_IDS
from homebot.discovery.merging.parts import CONFIRM
from homebot.discovery.merging.trust import NOBODY_TRUSTED, EndpointKey, command_endpoints, endpoint_of, judge
from homebot.discovery.pending import PendingReports
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.discovery.states import is_denied
from homebot.discovery.topics.use import bridge_of, topic_use
from homebot.errors import RefusedError
from homebot.messages import Time

_MAX_EVIDENCE = 16
_MAX_PANELS: Final = 1000
"""Identifiers of alarm panels; those of further panels do not count."""
_KEY, _REACH = attrgetter("key"), attrgetter("reach")
_FIRST_SEEN, _TIME = attrgetter("first_seen"), attrgetter("sec", "nanosec")


class Regrouped(NamedTuple):
    """A device after regrouping.

    Attributes:
        keys: Its announcements, oldest first.
        keeps: Its former device; None for a new one.
        gone: Devices merged into it.
        parents: Devices from which some of its announcements were split off.
    """

    keys: tuple[SourceKey, ...]
    keeps: Entry | None
    gone: tuple[Entry, ...]
    parents: tuple[Entry, ...]


def regroup(
    groups: Iterable[frozenset[SourceKey]], owners: Mapping[SourceKey, Entry], sources: Mapping[SourceKey, SourceRecord]
) -> tuple[Regrouped, ...]:
    """Return the devices that *groups* of announcements describe.

    A device stays with its oldest announcement; of merged devices, the one with the oldest announcement remains.

    Args:
        owners: Their former devices; new announcements have none.
        sources: The announcements; smaller numbers are older.
    """

    def age(key: SourceKey) -> int:
        return sources[key].number

    ordered = sorted((tuple(sorted(group, key=age)) for group in groups), key=lambda keys: age(keys[0]))
    planned: list[tuple[tuple[SourceKey, ...], Entry | None, list[Entry]]] = []
    kept: set[str] = set()
    for keys in ordered:
        entries = list(dict.fromkeys(owners[key] for key in keys if key in owners))
        members = frozenset(keys)
        keeps = next(
            (entry for entry in entries if entry.id not in kept and next(iter(entry.sources)) in members), None
        )
        if keeps is not None:
            kept.add(keeps.id)
        planned.append((keys, keeps, entries))
    return tuple(_regroup(*group, kept) for group in planned)


def _regroup(keys: tuple[SourceKey, ...], keeps: Entry | None, entries: Iterable[Entry], kept: set[str]) -> Regrouped:
    gone = () if keeps is None else tuple(entry for entry in entries if entry.id not in kept)
    return Regrouped(keys, keeps, gone, tuple(entry for entry in entries if entry.id in kept and entry is not keeps))


def find_panel(table: DeviceTable, entry: Entry) -> None:
    """Record the alarm panel on which *entry* hangs, and if it is a new panel itself, which devices hang on it.

    A switch of such a device may bypass a zone of the panel.
    """
    if table.panels:
        entry.panel = _panel_of(entry, table.panels)
    sightings = [source.sighting for source in entry.sources.values()]
    panels = [
        sighting for sighting in sightings if any(part.service_type == "x_alarm_panel" for part in sighting.parts)
    ]
    new = {name for panel in panels for name in panel.identifiers} - table.panels
    if not new or len(table.panels) >= _MAX_PANELS:
        return
    table.panels |= new
    for other in table.entries.values():
        if other is not entry and (panel := _panel_of(other, new)):
            other.invalidate_description()
            other.panel = panel
            table.record_change("changed", other, f"it hangs on the alarm panel {entry.id}")


def _panel_of(entry: Entry, panels: Container[str]) -> str:
    """Return the identifier among *panels* behind which *entry* is announced; empty if there is none.

    Devices that announce themselves, or whose bridge does, hang on none: otherwise a stranger's panel with the
    identifier of a bridge would make all its switches ask.
    """
    if any(source.sighting.native for source in entry.sources.values()):
        return ""
    bridges = identifiers(bridge_of(source.sighting) for source in entry.sources.values())
    return next((bridge for bridge in bridges if bridge in panels), "")


@final
class DeviceMerger:
    """Keeps each device in line with its set of announcements."""

    def __init__(self, table: DeviceTable, liveness: Liveness, pending: PendingReports) -> None:
        self.decisions = MergeDecisions()
        self.identities = IdentityGraph(self.decisions)
        self._table = table
        self._liveness = liveness
        self._pending = pending

    def appear(self, sources: dict[SourceKey, SourceRecord], why: str) -> Entry:
        """Create a device from *sources*; one that returns gets its old id."""
        table = self._table
        tombstone = self._pop_tombstone(sources) if table.tombstones.by_id else None
        first_seen = min(map(_FIRST_SEEN, sources.values()), key=_TIME)
        if tombstone is not None:
            device_id, trusted = tombstone.id, frozenset(tombstone.trusted)
            first_seen = min(first_seen, Time.from_seconds(tombstone.first_seen), key=_TIME)
        else:
            first = next(iter(sources.values())).sighting
            device_id, trusted = new_id(first, table.entries, table.tombstones.by_id), NOBODY_TRUSTED
        entry = Entry(
            device_id,
            first_seen,
            "unconfirmed",
            sources,
            known_ids=NO_IDS,
            owner=table.owner,
        )
        entry.trusted = trusted
        if not table.owner.is_empty:
            table.owner.adopt(device_id, sources.values())
        table.entries[device_id] = entry
        for key, source in sources.items():
            table.owners[key] = entry
            if source.confirmed:
                entry.freshness = "fresh"
                entry.report_interval.record(source.heard_at)
        self.describe(entry)
        now = self._liveness.now
        for source in sources.values():
            self._liveness.extend(entry, source, now if source.heard_at == -math.inf else source.heard_at)
        table.record_change("appeared", entry, why if tombstone is None else f"it returned: {why}")
        return entry

    def join(self, entry: Entry, source: SourceRecord, sibling: SourceKey) -> None:
        """Add *source*, which has the same identity as *sibling*, another announcement of the device.

        This is the usual case of a device announced in many messages, and needs no regrouping.
        """
        entry.sources[source.key] = source
        self._table.owners[source.key] = entry
        if not self._table.owner.is_empty:
            self._table.owner.inherit(sibling, source.key)
        self.describe(entry, source)
        if entry.freshness == "unconfirmed":
            self._liveness.extend(entry, source, self._liveness.now)
        self._table.changes.add_growth(entry, "it announces more capabilities")

    def restore(self, entry: Entry, now: float, wall: float) -> None:
        """Restore a device from the *entry* of an index file, unconfirmed."""
        for key, source in entry.sources.items():
            self._table.owners[key] = entry
            self.identities.put(key, source.sighting)
        entry.freshness, entry.owner = "unconfirmed", self._table.owner
        self._table.entries[entry.id] = entry
        self._table.owner.adopt(entry.id, entry.sources.values())
        self.describe(entry)
        self._liveness.restart(entry, now, wall)
        self._table.record_change("appeared", entry, "it was known before the last start")

    def remove(self, entry: Entry, why: str, *, retained_only: bool, at: float) -> None:
        """Remove *entry* with its announcements.

        Args:
            retained_only: Whether retained announcements must not bring it back.
            at: When, in seconds since the Unix epoch.
        """
        table = self._table
        table.changes.add_removal(entry, why)
        trusted = entry.trusted or command_endpoints(entry.sources.values())
        keys, hardware, first_seen = tuple(entry.sources), entry.hardware(), entry.first_seen.to_seconds()
        tombstone = Tombstone(entry.id, keys, hardware, retained_only, at, tuple(sorted(trusted)), first_seen)
        self._drop(entry)
        affected: set[SourceKey] = set()
        for key, source in entry.sources.items():
            if retained_only:
                self._pending.remember_forgotten(key, source.sighting)
            self.identities.unbind(key)
            affected |= self.identities.discard(key)
            del table.sources[key], table.owners[key]
            self._refresh_conflicts(table.topics.discard(key))
        forgotten = table.tombstones.put(tombstone)
        if forgotten is not None:
            table.mark_unsaved(forgotten.id)
        if affected := affected - entry.sources.keys():
            self.regroup(affected, f"{entry.id} is gone: {why}")

    def withdraw(self, entry: Entry, key: SourceKey, why: str) -> None:
        """Remove one of several announcements of *entry*."""
        table = self._table
        self.identities.unbind(key)
        affected = self.identities.discard(key)
        del table.sources[key], table.owners[key], entry.sources[key]
        self._refresh_conflicts(table.topics.discard(key))
        self.regroup(affected, why)
        self.describe(entry)
        table.record_change("changed", entry, f"it announces fewer capabilities: {why}")

    def join_repetitions(self, key: SourceKey) -> None:
        """Merge announcements of one part into one device, such as one left over from a rename.

        They have the same commands on the same topics, so that each command would be executed twice.
        """
        table = self._table
        repetitions = table.topics.repetitions(key)
        if not repetitions:
            if self.identities.unbind(key):
                self.regroup(self.identities.put(key, table.sources[key].sighting), "it is no longer announced twice")
        elif self.identities.bind((key, *repetitions)):
            affected = {key}
            for repeated in (key, *repetitions):
                affected |= self.identities.put(repeated, table.sources[repeated].sighting)
            self.regroup(affected, "it is announced more than once, with the same commands")

    def regroup(self, affected: Iterable[SourceKey], why: str) -> None:
        """Regroup the announcements *affected* into devices."""
        table = self._table
        for group in regroup(self.identities.groups(affected), table.owners, table.sources):
            if group.keeps is not None:
                self._merge(group.keeps, group, why)
            else:
                for parent in group.parents:
                    for key in group.keys:
                        parent.sources.pop(key, None)
                entry = self.appear({key: self._table.sources[key] for key in group.keys}, why)
                for parent in group.parents:
                    self.describe(parent)
                    self._table.record_change(
                        "unmerged", parent, f"{entry.id} turned out to be another device", entry.id
                    )

    def split(self, device_id: str, key: SourceKey | None, now: float) -> tuple[str, ...]:
        """Split a device, because the owner says so; return the resulting ids, that of the original first.

        Args:
            key: The announcement to split off, with those of the same identity; None to split off each.

        Raises:
            RefusedError: There is no such device or announcement, nothing was merged, or there are too many decisions.
        """
        entry = self._entry(device_id)
        if key is not None and key not in entry.sources:
            known = ", ".join(f"{gateway} {name}" for gateway, name in entry.sources)
            raise RefusedError(f"a split of {device_id}", f"it has no announcement {' '.join(key)}; it has {known}")
        self._liveness.now = now
        keys = tuple(entry.sources)
        shared = [identifier for identifier, _ in self.identities.shared(keys)]
        if not shared:
            raise RefusedError(f"a split of {entry.id}", "nothing was merged into it")
        self.decisions.split(shared, self.decisions.merged_with(keys))
        if key is not None and len(rest := self._eldest_beside(key, keys)) > 1:
            self.decisions.merge(rest)
        self._decide(keys, shared, "the owner split it")
        return tuple(dict.fromkeys((entry.id, *(self._table.owners[source_key].id for source_key in keys))))

    def _eldest_beside(self, key: SourceKey, keys: Iterable[SourceKey]) -> list[SourceKey]:
        """Return the oldest announcement of each identity among *keys*, except that of *key*."""
        eldest = {source_key: self.identities.same_identity(source_key) or source_key for source_key in keys}
        return sorted(set(eldest.values()) - {eldest[key]})

    def merge(self, device_ids: Iterable[str], now: float) -> str:
        """Merge devices, because the owner says so; return the resulting id, that of the oldest.

        All its endpoints may get its commands from now on.

        Args:
            device_ids: The devices; a single one to trust its claimed endpoints.

        Raises:
            RefusedError: There is no such device, there is nothing to merge, or there are too many decisions.
        """
        entries = tuple(self._entry(device_id) for device_id in dict.fromkeys(device_ids))
        if not entries or (len(entries) == 1 and not entries[0].claimed):
            raise RefusedError("a merge", "it takes two different devices")
        self._liveness.now = now
        keys = tuple(next(iter(entry.sources)) for entry in entries)
        if len(keys) > 1:
            self.decisions.merge(keys)
            self._decide(keys, (), "the owner merged them")
        entry = self._table.owners[keys[0]]
        if entry.claimed:
            self._set_trusted(entry, entry.claimed, "the owner confirmed all its endpoints")
        return entry.id

    def _entry(self, device_id: str) -> Entry:
        entry = self._table.entries.get(device_id)
        if entry is None:
            raise RefusedError(f"a change of {device_id!r}", "there is no device of that id")
        return entry

    def trust(self, entry: Entry, endpoints: frozenset[EndpointKey]) -> None:
        """Let *endpoints* get the commands of *entry*: they reported the same changes as trusted ones."""
        names = ", ".join(sorted(gateway for gateway, _ in endpoints))
        self._set_trusted(entry, endpoints, f"{names} reported the same changes as its other endpoints")

    def _set_trusted(self, entry: Entry, endpoints: frozenset[EndpointKey], why: str) -> None:
        entry.trusted |= endpoints
        self.describe(entry)
        self._table.record_change("changed", entry, why)

    def _judge(self, entry: Entry, new: SourceRecord | None) -> bool:
        """Decide which endpoints of *entry* are trusted; return whether that changes older ones."""
        sources = entry.sources.values()
        if not (entry.trusted or entry.claimed):
            first = next(iter(sources))
            if len(sources) == 1:
                first.is_claimed = False
                return False
            if new is not None and endpoint_of(new) == endpoint_of(first):
                return False
        before = entry.claimed
        entry.trusted = judge(sources, entry.trusted)
        entry.claimed = frozenset([endpoint_of(source) for source in sources if source.is_claimed])
        if not entry.claimed:
            entry.agreement = None
        return entry.claimed != before

    def _decide(self, keys: Iterable[SourceKey], identifiers: Iterable[str], why: str) -> None:
        """Regroup the announcements *keys* after a decision on them and on *identifiers*."""
        self.identities.forget_links(identifiers)
        affected = set(keys)
        for key in keys:
            affected |= self.identities.put(key, self._table.sources[key].sighting)
        self.regroup(affected, why)

    def describe(self, entry: Entry, new: SourceRecord | None = None) -> None:
        """Update the description of *entry*: all its announcements may have changed, or *new* was added."""
        table = self._table
        entry.invalidate_description()
        if self._judge(entry, new):
            new = None
        sources = tuple(entry.sources.values()) if new is None else (new,)
        if new is None:
            self._describe_again(entry, sources)
        else:
            entry.is_shared |= new.key[0] != next(iter(entry.sources))[0]
        concerned: set[str] = set()
        may_be_panel = False
        for source in sources:
            entry.silence_allowed = max(entry.silence_allowed, source.lasts)
            use = topic_use(source, entry.id)
            concerned |= table.topics.put(use)
            may_be_panel |= use.asks
        if concerned:
            self._refresh_conflicts(concerned)
        if len(entry.sources) > 1:
            table.judge_topics(entry)
        if may_be_panel or table.panels:
            find_panel(table, entry)
        table.outdated[entry.id] = None
        table.mark_unsaved(entry.id)
        if table.topics.denied or entry.topic_owner:
            self._refresh_topic_owner(entry, sources, is_whole=new is None)

    def _describe_again(self, entry: Entry, sources: tuple[SourceRecord, ...]) -> None:
        """Update what follows from all announcements of *entry* together."""
        entry.is_shared = len(sources) > 1 and len(entry.gateways()) > 1
        if entry.stale_gateways:
            entry.stale_gateways &= entry.gateways()
        entry.evidence = tuple(self._evidence(entry)) if len(sources) > 1 else ()
        entry.doubts = self._doubts(sources) if self.identities.told_apart > 1 else ()
        entry.silence_allowed = 0.0
        entry.is_denied = bool(self._table.lost or any(map(_REACH, sources))) and is_denied(sources)

    def _refresh_topic_owner(self, entry: Entry, sources: Iterable[SourceRecord], *, is_whole: bool) -> None:
        """Look for a device that claims a topic of *sources* of *entry*; *is_whole* if these are all its sources."""
        table, owner = self._table, ""
        if denied := table.topics.denied:
            for source in sources:
                if source.key in denied and (owner := self._topic_owner(entry, source)):
                    break
        if not is_whole and not owner:
            return
        before, entry.topic_owner = entry.topic_owner, owner
        if owner and owner != before:
            why = f"{entry.id} takes commands on its topic"
            table.record_change("conflict", table.entries[owner], why, entry.id)

    def _pop_tombstone(self, sources: dict[SourceKey, SourceRecord]) -> Tombstone | None:
        """Forget the removed device of *sources*; return it if it is back and its id is free."""
        tombstones = self._table.tombstones
        for key, source in sources.items():
            if (tombstone := tombstones.find(key, source.sighting.identifiers)) is not None:
                tombstones.pop(tombstone.id)
                return None if tombstone.id in self._table.entries else tombstone
        return None

    def _drop(self, entry: Entry) -> None:
        self._table.drop(entry)
        self._liveness.deadlines.discard(entry.id)

    def _merge(self, entry: Entry, group: Regrouped, why: str) -> None:
        table = self._table
        sources = {key: table.sources[key] for key in group.keys}
        new = sources.keys() - entry.sources.keys()
        if not new and len(sources) == len(entry.sources):
            if entry.doubts != self._doubts(sources.values()):
                self.describe(entry)
                table.record_change("changed", entry, "its disputes changed")
            return
        silent = silent_gateways((entry, *group.gone))
        for other in group.gone:
            self._absorb(entry, other)
        entry.sources, entry.stale_gateways = sources, silent
        table.owners.update(dict.fromkeys(sources, entry))
        before = entry.evidence
        self.describe(entry)
        self._liveness.schedule(entry)
        evidence = "; ".join(reason for reason in entry.evidence if reason not in before)
        for other in group.gone:
            table.record_change("merged", entry, evidence or why, other.id)
        if new and not group.gone:
            if evidence:
                self._table.record_change("merged", entry, evidence)
            else:
                self._table.record_change("changed", entry, "it announces more capabilities")

    def _absorb(self, entry: Entry, other: Entry) -> None:
        """Merge *other* into *entry*, with the longer silence and the newer sign of life."""
        self._table.changes.add_removal(other, f"it is the same device as {entry.id}", entry.id)
        self._drop(other)
        entry.report_interval.join(other.report_interval)
        if other.deadline > entry.deadline:
            entry.deadline, entry.expires = other.deadline, other.expires
        if other.freshness == "fresh" or entry.freshness == "stale":
            entry.freshness = other.freshness

    def _evidence(self, entry: Entry) -> Iterator[str]:
        sources = self._table.sources
        for number, (identifier, keys) in enumerate(self.identities.shared(entry.sources)):
            if number >= _MAX_EVIDENCE:
                break
            labels = " and ".join(
                f"{sources[key].label} on {key[0]}" if entry.is_shared else sources[key].label for key in keys
            )
            if identifier.startswith(OWNER):
                yield f"the owner merged {labels}"
            elif identifier.startswith(REPEATED):
                yield f"same commands in {labels}; one may be left over from a rename: delete its retained message"
            else:
                yield f"same {identifier} in {labels}"
        for source in entry.sources.values():
            if source.is_claimed:
                yield f"{source.label} on {source.key[0]} only claims to be it, and gets no commands yet; {CONFIRM}"

    def _doubts(self, sources: Iterable[SourceRecord]) -> tuple[str, ...]:
        """Return the identifiers that *sources* of a device share with another that their gateway tells apart."""
        known, keys = self._table.sources, tuple(map(_KEY, sources))
        doubts: list[str] = []
        for identifier, key, other in self.identities.claimed_twice(keys):
            if other not in keys and len(doubts) < _MAX_EVIDENCE:
                doubts.append(
                    f"{known[key].label} and {known[other].label} on {key[0]} claim the same {identifier}, "
                    "which identifies neither"
                )
        return tuple(doubts)

    def _refresh_conflicts(self, concerned: Iterable[str]) -> None:
        """Update devices that share a topic with one that was added or removed."""
        table = self._table
        for device_id in concerned:
            entry = table.entries.get(device_id)
            if entry is None:
                continue
            entry.invalidate_description()
            table.outdated[device_id] = None
            if entry.published_conflicts != entry.parts(table.topics).conflicts:
                table.record_change("changed", entry, "its disputes changed")

    def _topic_owner(self, entry: Entry, source: SourceRecord) -> str:
        """Return the device that claims a topic of *source*; empty if none does."""
        table = self._table
        for part in source.sighting.parts:
            for topic in part.writes:
                owner = table.topics.owner(source.key, topic)
                if owner and owner != entry.id and owner in table.entries:
                    return owner
        return ""
