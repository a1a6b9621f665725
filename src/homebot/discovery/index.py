"""The index: who is out there, what they offer, and how fresh that knowledge is. Pure; the time comes from outside.

It holds devices, not topics: however many messages, announcements and addresses a device has, it is one entry. What
happens to devices is collected until :meth:`DeviceIndex.take_changes`, so that a device that is announced in thirty
messages is told of once.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from typing import final

from homebot.devices import Device, DeviceChange, Sighting, State, StateChange
from homebot.devices.capabilities import EVENTS
from homebot.devices.device import ChangeKind
from homebot.devices.part import Part
from homebot.devices.query import Query, facets_of, type_is
from homebot.devices.report import REACHABLE, Reading, Report
from homebot.discovery.change_queue import ChangeQueue
from homebot.discovery.command_topics import NOBODY, TopicOwnership, topic_use
from homebot.discovery.entry import Entry
from homebot.discovery.ids import Tombstone, Tombstones, new_id
from homebot.discovery.merging.identity import IdentityGraph
from homebot.discovery.merging.parts import MergedParts
from homebot.discovery.merging.regroup import Regrouped, regroup
from homebot.discovery.pending import PendingReports
from homebot.discovery.search.postings import Postings
from homebot.discovery.source_record import SourceKey, SourceRecord, StoredValue, is_described_anew, note_description
from homebot.discovery.states import NOT_ANNOUNCED, has_capability, is_denied, state_of, store_reachability, store_value
from homebot.messages import Time
from homebot.timer_queue import TimerQueue

__all__ = ["MAX_DEVICES", "MAX_SOURCES", "DeviceIndex", "IndexCounters"]

MAX_DEVICES = 100_000

MAX_SOURCES = 1000
"""Announcements of one device; further ones are rejected."""

SAVE_LIFE = 600.0
"""Seconds between two writings of when a device was last seen."""

_CLAIMS_PER_DEVICE = 10
"""Announcements that the index takes in, for each device that it may hold."""

_MAX_EVIDENCE = 16
_MAX_UNSAVED = 200_000

_ONLINE_FOR = 86_400.0
"""Seconds for which a device that said live that it is online may be silent: its last will watches over it."""


@dataclass(slots=True)
class IndexCounters:
    """What was not taken in.

    Attributes:
        rejected: Announcements of new devices while the index was full, and those of a device that has too many.
        retained_only: Announcements that the broker had kept, of devices that were forgotten.
        unknown_parts: Readings of parts that were not announced, or not with that capability; they change nothing.
    """

    rejected: int = 0
    retained_only: int = 0
    unknown_parts: int = 0


@final
class DeviceIndex:
    """Every known device, kept up to date by sightings, reports and the passing of time.

    Args:
        forget_after: Seconds for which a stale device stays in the index before it is removed.
        first_sequence: Number of the first change; a new index that follows an old one starts above it.
        max_devices: How many it takes in.

    Attributes:
        counters: What was not taken in.
        tombstones: Who went.
        is_saved: Whether there is an index file, so that it is noted what is not in it.
        unsaved: Ids whose record is not in the index file as it is; of those that went as well. Should nobody write for
            so long that 200,000 wait, those that are known now take their place.
        tells_states: Whether changes of states are collected.
    """

    def __init__(self, *, forget_after: float, first_sequence: int = 1, max_devices: int = MAX_DEVICES) -> None:
        self.counters = IndexCounters()
        self.tombstones = Tombstones()
        self.is_saved = False
        self.unsaved: dict[str, None] = {}
        self.tells_states = False
        self._forget_after = forget_after
        self._max_devices = max_devices
        self._sources: dict[SourceKey, SourceRecord] = {}
        self._owner: dict[SourceKey, Entry] = {}
        self._entries: dict[str, Entry] = {}
        self._identities = IdentityGraph()
        self._topic_ownership = TopicOwnership()
        self._deadlines: TimerQueue[str, None] = TimerQueue()
        self._postings = Postings()
        self._unsorted: dict[str, None] = {}
        self._changes = ChangeQueue(self._device, first_sequence)
        self._pending = PendingReports()
        self._number = 0
        self._now = -math.inf

    def __len__(self) -> int:
        return len(self._entries)

    def counts(self) -> dict[str, int]:
        """Return what was not taken in, and what was dropped, by name."""
        return {
            **asdict(self.counters),
            "strays": self._pending.count,
            "identifiers_cut": self._identities.cut,
            "states_lost": self._changes.states_lost,
        }

    @property
    def sequence(self) -> int:
        """Number of the last change that was taken."""
        return self._changes.sequence

    def observe(self, sighting: Sighting, now: float | None = None) -> None:
        """Take *sighting* in.

        Args:
            sighting: What a gateway heard.
            now: When, in seconds of the clock that :meth:`expire` is asked with, one that is never set; by default its
                stamp is the time, as of something recorded.
        """
        self._now = sighting.seen_at.to_seconds() if now is None else now
        key = (sighting.gateway, sighting.key)
        claim = self._sources.get(key)
        if sighting.kind == "removed":
            if claim is not None:
                self._withdraw(key, sighting.why)
        elif claim is None:
            self._add(key, sighting)
        else:
            self._refresh(key, claim, sighting)

    def report(self, report: Report, now: float | None = None) -> None:
        """Take in what a device told; of one that nobody announced yet it waits a moment, and is counted.

        Args:
            report: What it told.
            now: As for :meth:`observe`.
        """
        self._now = report.received_at.to_seconds() if now is None else now
        key = (report.gateway, report.key)
        claim = self._sources.get(key) or self._woken(key, report)
        if claim is None:
            self._pending.put(key, report, self._now)
            return
        entry, live = self._owner[key], not report.retained
        is_life = live and report.address != ""
        before = self._reach(entry) if entry.is_denied else None
        for reading in report.readings:
            capability = reading.capability
            if capability == REACHABLE:
                before = before or self._reach(entry)
                if report.address:
                    store_reachability(entry, claim, reading, report.received_at, self._now, live=live)
                else:  # it tells that no more
                    claim.set_reach({part: one for part, one in claim.reach.items() if part != reading.part})
                is_life = is_life and reading.value.flag
            elif capability in EVENTS:
                if live:
                    self._happen(entry, claim, reading, report.received_at)
            elif (told := store_value(claim, reading, report, self._now)) is not None:
                self._store_value(entry, claim, reading, told)
        if is_life:
            self._mark_seen(entry, claim, report.received_at, "it spoke itself")
        else:
            entry.invalidate_device()
        if before is not None and self._reach(entry) != before:
            self._note("changed", entry, entry.reachability().why)

    def _woken(self, key: SourceKey, report: Report) -> SourceRecord | None:
        """The announcement of a device that was forgotten, where *report* shows that it is alive."""
        sighting = self._pending.revive(report)
        if sighting is not None:
            self._add(key, sighting)
        return self._sources.get(key)

    def _reach(self, entry: Entry) -> tuple[str, tuple[str, ...]]:
        """Whether it can be reached, and which of its parts cannot."""
        return entry.reachability().state, entry.offline_parts(entry.parts(self._disputed))

    def expire(self, now: float, at_most: int | None = None) -> int:
        """Let become stale what is silent for too long at *now*, and forget what is stale for too long.

        Args:
            now: Seconds of a clock that is never set: who sets the computer's makes nobody stale.
            at_most: How many changes to make. None makes them all.

        Returns:
            How many were made; ask again until it is none.
        """
        made = 0
        while (at_most is None or made < at_most) and (due := self._deadlines.pop(now)) is not None:
            made += 1
            device_id, _ = due
            entry = self._entries[device_id]
            if entry.freshness == "stale":
                at = entry.expires + self._forget_after
                self._remove(entry, "it has been stale for too long", is_ghost=True, at=at)
                continue
            entry.freshness = "stale"
            self._deadlines.set(device_id, entry.deadline + self._forget_after, None)
            self._note("stale", entry, "it has been silent for too long")
        return made

    def next_deadline(self) -> float | None:
        """Return when :meth:`expire` has something to do, in seconds of its clock; None for never."""
        return self._deadlines.next()

    def take_changes(self, at_most: int | None = None) -> tuple[DeviceChange, ...]:
        """Return what happened, oldest first, and forget it; what became of one device meanwhile is in its change.

        Args:
            at_most: How many to take; None for all.
        """
        return self._changes.take(at_most)

    @property
    def has_states(self) -> bool:
        """Whether changes of states wait to be taken."""
        return self._changes.has_states

    def take_states(self, at_most: int | None = None) -> tuple[StateChange, ...]:
        """Return the changes of states, oldest first, and forget them; to be called after :meth:`take_changes`.

        Those of parts and capabilities that went meanwhile are left out.

        Args:
            at_most: How many to look at; None for all.
        """
        return self._changes.take_states(self._is_current, at_most)

    def devices(self, service_type: str = "") -> tuple[Device, ...]:
        """Return the devices that offer *service_type* (all of them when it is empty), sorted by id."""
        found = self.find(type_is(service_type)) if service_type else self._entries
        return tuple(self._device(self._entries[one]) for one in sorted(found))

    def get(self, device_id: str) -> Device | None:
        """Return the device *device_id*, or None."""
        entry = self._entries.get(device_id)
        return self._device(entry) if entry is not None else None

    def find(self, query: Query) -> frozenset[str] | set[str]:
        """Return the ids of the devices that fit *query*; not to be changed."""
        self.sort()
        return self._postings.find(query)

    @property
    def postings(self) -> Postings:
        """What the devices can be found by; up to date after :meth:`sort`."""
        return self._postings

    def sort(self, at_most: int | None = None) -> bool:
        """Make devices that changed findable, at most so many; return whether some are left.

        :meth:`find` does it by itself; who does it before has the answer sooner.
        """
        done = 0
        while self._unsorted and (at_most is None or done < at_most):
            device_id = next(iter(self._unsorted))
            del self._unsorted[device_id]
            entry = self._entries[device_id]
            device = self._device(entry)
            merged = entry.parts(self._disputed)
            types = {part.id: part.part.service_type for part in merged.parts}
            values = [(one.part, types[one.part], one.capability, one.value.plain()) for one in device.states]
            self._postings.put(facets_of(device), values)
            done += 1
        return bool(self._unsorted)

    def forget(self, device_id: str, now: float) -> tuple[tuple[str, str], ...] | None:
        """Remove the device; announcements of it that the broker keeps do not bring it back, its own word does.

        Args:
            device_id: Its id.
            now: Seconds since the Unix epoch, for the tombstone.

        Returns:
            Gateway and place of its announcements; None where there is no such device.
        """
        entry = self._entries.get(device_id)
        if entry is None:
            return None
        announced = [one.sighting for one in entry.sources.values()]
        self._remove(entry, "somebody wants it forgotten", is_ghost=True, at=now)
        return tuple((one.gateway, one.announced_on) for one in announced if one.announced_on)

    def entry(self, device_id: str) -> Entry | None:
        """Return what is kept of the device, for the index file."""
        entry = self._entries.get(device_id)
        if entry is not None:
            entry.parts(self._disputed)  # so that those that are new have their ids
        return entry

    def save_all(self) -> None:
        """Note that nothing is in the index file."""
        self.unsaved.update(dict.fromkeys(self._entries))
        self.unsaved.update((stone.id, None) for stone in self.tombstones)

    def restore(self, entry: Entry, now: float, wall: float | None = None) -> None:
        """Take in a device of the index file, unconfirmed, before anything else is taken in.

        Args:
            entry: The device.
            now: Seconds of the clock that :meth:`expire` is asked with: it has its whole time from now on, for how long
                homebot was away nobody knows whose clock was set meanwhile.
            wall: Seconds since the Unix epoch, for its stamp; by default the same.
        """
        if entry.id in self._entries or len(self._entries) >= self._max_devices or not entry.sources:
            return
        if any(key in self._sources for key in entry.sources):
            return
        for key, claim in entry.sources.items():
            self._number += 1
            claim.number = self._number
            self._sources[key] = claim
            self._owner[key] = entry
            self._identities.put(key, claim.sighting)
        entry.freshness = "unconfirmed"
        lasts = max(claim.lasts for claim in entry.sources.values())
        entry.deadline, entry.expires = now + lasts, (now if wall is None else wall) + lasts
        self._entries[entry.id] = entry
        self._describe(entry)
        self._deadlines.set(entry.id, entry.deadline, None)
        self._note("appeared", entry, "it was known before the start")

    def _add(self, key: SourceKey, sighting: Sighting) -> None:
        stone = self.tombstones.find(key, ())
        if stone is not None and stone.retained_only and not sighting.confirmed:
            self.counters.retained_only += 1
            self._pending.remember_forgotten(key, sighting)
            return
        if len(self._sources) >= _CLAIMS_PER_DEVICE * self._max_devices:
            self.counters.rejected += 1
            return
        claim = SourceRecord(
            sighting=sighting,
            number=0,
            first_seen=sighting.seen_at,
            seen_at=sighting.seen_at,
            confirmed=sighting.confirmed,
            heard_at=self._now,
        )
        key = claim.key  # one object, wherever it is kept
        affected = self._identities.put(key, sighting)
        sibling = self._identities.same_identity(key)
        is_alone = sibling is None and len(affected) == 1
        count = len(self._owner[sibling].sources) + 1 if sibling is not None else len(affected)
        if count > MAX_SOURCES or (is_alone and len(self._entries) >= self._max_devices):
            self._identities.discard(key)
            self.counters.rejected += 1
            return
        self._number += 1
        self._sources[key] = claim
        claim.number = self._number
        is_late = sighting.kind == "updated" and bool(sighting.announced_on)  # the first word was overtaken
        why = "it was announced" if is_late else sighting.why
        if is_alone:
            self._appear({key: claim}, why)
        elif sibling is not None:
            self._join(self._owner[sibling], claim)
        else:
            self._regroup(affected, why)
        if sighting.confirmed and not is_alone:
            self._mark_seen(self._owner[key], claim, sighting.seen_at, why)
        for report in self._pending.take(key, self._now):
            self.report(report, self._now)

    def _join(self, entry: Entry, claim: SourceRecord) -> None:
        """The usual case, a further announcement of the same device in the same way, without a look at all others."""
        entry.sources[claim.key] = claim
        self._owner[claim.key] = entry
        self._describe(entry, claim)
        if entry.freshness == "unconfirmed":
            self._lengthen(entry, claim, self._now)
        self._note("changed", entry, "it announces more")

    def _refresh(self, key: SourceKey, claim: SourceRecord, sighting: Sighting) -> None:
        before, claim.sighting = claim.sighting, sighting
        entry = self._owner[key]
        is_new = is_described_anew(before, sighting)
        if is_new:
            note_description(claim, before)
            if affected := self._identities.put(key, sighting):
                self._regroup(affected, "it says anew who it is")
                entry = self._owner[key]
            self._describe(entry)
            self._note("changed", entry, "it is described anew")
        if sighting.confirmed:
            self._mark_seen(entry, claim, sighting.seen_at, "it spoke itself")
        elif not claim.confirmed and entry.freshness == "unconfirmed":
            claim.seen_at, claim.heard_at = sighting.seen_at, self._now
            entry.invalidate_device()
            self._lengthen(entry, claim, self._now)

    def _withdraw(self, key: SourceKey, why: str) -> None:
        entry = self._owner[key]
        if len(entry.sources) == 1:
            self._remove(entry, why, is_ghost=False, at=entry.last_seen().to_seconds())
            return
        affected = self._identities.discard(key)
        del self._sources[key], self._owner[key], entry.sources[key]
        self._refresh_conflicts(self._topic_ownership.discard(key))
        self._regroup(affected, why)
        self._describe(entry)
        self._note("changed", entry, f"it announces less: {why}")

    def _appear(self, claims: dict[SourceKey, SourceRecord], why: str) -> Entry:
        first = next(iter(claims.values()))
        stone = self._stone(claims)
        if stone is not None:
            self.tombstones.take(stone.id)
        is_back = stone is not None and stone.id not in self._entries
        device_id = stone.id if stone is not None and is_back else new_id(first.sighting, self._is_taken)
        confirmed = any(claim.confirmed for claim in claims.values())
        first_seen = min((claim.first_seen for claim in claims.values()), key=lambda one: (one.sec, one.nanosec))
        entry = Entry(device_id, first_seen, "fresh" if confirmed else "unconfirmed", claims)
        self._entries[device_id] = entry
        self._owner.update(dict.fromkeys(claims, entry))
        for claim in claims.values():
            if claim.confirmed:
                entry.report_interval.record(claim.heard_at)
        self._describe(entry)
        for claim in claims.values():
            self._lengthen(entry, claim, self._now if claim.heard_at == -math.inf else claim.heard_at)
        self._note("appeared", entry, f"it is back: {why}" if is_back else why)
        return entry

    def _stone(self, claims: dict[SourceKey, SourceRecord]) -> Tombstone | None:
        for key, claim in claims.items():
            hardware = (one for one in claim.sighting.identifiers if not one.startswith("id:"))
            if (stone := self.tombstones.find(key, hardware)) is not None:
                return stone
        return None

    def _is_taken(self, device_id: str) -> bool:
        return device_id in self._entries or device_id in self.tombstones

    def _remove(self, entry: Entry, why: str, *, is_ghost: bool, at: float) -> None:
        self._changes.note_removed(entry, why)
        stone = Tombstone(entry.id, tuple(entry.sources), entry.hardware(), is_ghost, at)
        self._drop(entry)
        affected: set[SourceKey] = set()
        for key, claim in entry.sources.items():
            if is_ghost:
                self._pending.remember_forgotten(key, claim.sighting)
            affected |= self._identities.discard(key)
            del self._sources[key], self._owner[key]
            self._refresh_conflicts(self._topic_ownership.discard(key))
        forgotten = self.tombstones.put(stone)
        if forgotten is not None:
            self._mark_unsaved(forgotten.id)
        if affected := affected - entry.sources.keys():
            self._regroup(affected, f"{entry.id} is gone: {why}")

    def _drop(self, entry: Entry) -> None:
        del self._entries[entry.id]
        self._unsorted.pop(entry.id, None)
        self._postings.discard(entry.id)
        self._deadlines.discard(entry.id)
        self._mark_unsaved(entry.id)

    def _regroup(self, affected: Iterable[SourceKey], why: str) -> None:
        """Make the devices those that the announcements *affected* are about now."""
        for one in regroup(self._identities.groups(affected), self._owner, self._age):
            if one.keeps is not None:
                self._merge(one.keeps, one, why)
            else:
                self._split(one, why)

    def _age(self, key: SourceKey) -> int:
        return self._sources[key].number

    def _split(self, new: Regrouped, why: str) -> None:
        for parent in new.parents:
            for key in new.keys:
                parent.sources.pop(key, None)
        entry = self._appear({key: self._sources[key] for key in new.keys}, why)
        for parent in new.parents:
            self._describe(parent)
            self._note("unmerged", parent, f"{entry.id} turned out to be another device", entry.id)

    def _merge(self, entry: Entry, found: Regrouped, why: str) -> None:
        claims = {key: self._sources[key] for key in found.keys}
        new = claims.keys() - entry.sources.keys()
        if not new and len(claims) == len(entry.sources):
            return
        for other in found.gone:
            self._changes.note_removed(other, f"it is the same device as {entry.id}", entry.id)
            self._drop(other)
            entry.report_interval.join(other.report_interval)
            if other.deadline > entry.deadline:
                entry.deadline, entry.expires = other.deadline, other.expires
            if other.freshness == "fresh" or entry.freshness == "stale":
                entry.freshness = other.freshness
        entry.sources = claims
        self._owner.update(dict.fromkeys(claims, entry))
        before = entry.evidence
        self._describe(entry)
        self._set_deadline(entry)
        evidence = "; ".join(one for one in entry.evidence if one not in before)
        for other in found.gone:
            self._note("merged", entry, evidence or why, other.id)
        if new and not found.gone:
            self._note("merged" if evidence else "changed", entry, evidence or "it announces more")

    def _describe(self, entry: Entry, new: SourceRecord | None = None) -> None:
        """What the announcements of *entry* say changed, maybe by *new* alone: look anew at what follows from it."""
        entry.invalidate_description()
        claims = tuple(entry.sources.values()) if new is None else (new,)
        if new is None:
            entry.evidence = tuple(self._evidence(entry)) if len(claims) > 1 else ()
            entry.silence_allowed = max([claim.lasts for claim in claims])
            entry.is_denied = is_denied(claims)
        else:
            entry.silence_allowed = max(entry.silence_allowed, new.lasts)
        concerned: set[str] = set()
        for claim in claims:
            concerned |= self._topic_ownership.put(topic_use(claim, entry.id))
        if concerned:
            self._refresh_conflicts(concerned)
        self._unsorted[entry.id] = None
        self._mark_unsaved(entry.id)
        owner = ""
        for claim in claims:
            if owner := self._rival(entry, claim):
                break
        if new is not None and not owner:
            return
        before, entry.topic_owner = entry.topic_owner, owner
        if owner and owner != before:
            why = f"{entry.id} wants to be told things where it listens"
            self._note("conflict", self._entries[owner], why, entry.id)

    def _evidence(self, entry: Entry) -> Iterator[str]:
        for number, (identifier, keys) in enumerate(self._identities.shared(entry.sources)):
            if number >= _MAX_EVIDENCE:
                return
            yield f"same {identifier} in {' and '.join(self._sources[key].label for key in keys)}"

    def _refresh_conflicts(self, concerned: Iterable[str]) -> None:
        """Look anew at devices that share a topic with one that came or went."""
        for device_id in concerned:
            entry = self._entries.get(device_id)
            if entry is None:
                continue
            entry.invalidate_description()
            self._unsorted[device_id] = None
            if entry.published_conflicts != entry.parts(self._disputed).conflicts:
                self._note("changed", entry, "what is disputed about it changed")

    def _rival(self, entry: Entry, claim: SourceRecord) -> str:
        """The device that keeps a topic from *claim*; empty where none does."""
        for part in claim.sighting.parts:
            for topic in part.writes:
                owner = self._topic_ownership.owner(claim.key, topic)
                if owner and owner != entry.id and owner in self._entries:
                    return owner
        return ""

    def _disputed(self, claim: SourceRecord, part: Part) -> str:
        for topic in part.writes:
            owner = self._topic_ownership.owner(claim.key, topic)
            if owner:
                return self._dispute_in_words(claim, topic, owner)
        return ""

    def _dispute_in_words(self, claim: SourceRecord, topic: str, owner: str) -> str:
        wants = f"{claim.label} wants to be told things on {topic}, where"
        if owner == NOBODY:
            return f"{wants} too many others do"
        if owner == self._owner[claim.key].id:
            return f"{wants} another announcement of the device is told something else"
        return f"{wants} {owner} listens"

    def _mark_seen(self, entry: Entry, claim: SourceRecord, stamp: Time, why: str) -> None:
        now = self._now
        if now - entry.saved_at > SAVE_LIFE:
            entry.saved_at = now
            self._mark_unsaved(entry.id)
        claim.confirmed = True
        claim.seen_at, claim.heard_at = stamp, now
        usual = entry.report_interval.record(now)
        entry.invalidate_device()
        if usual < entry.silence_allowed:
            usual = entry.silence_allowed
        if usual < _ONLINE_FOR and claim.is_online:
            usual = _ONLINE_FOR
        before, entry.freshness = entry.freshness, "fresh"
        entry.deadline, entry.expires = now + usual, stamp.to_seconds() + usual
        self._deadlines.set(entry.id, entry.deadline, None)
        if before == "fresh":
            return
        self._unsorted[entry.id] = None
        if before == "stale":
            self._note("returned", entry, "it spoke again")
        else:
            self._note("changed", entry, why)

    def _lengthen(self, entry: Entry, claim: SourceRecord, heard: float) -> None:
        """Let *entry* be silent for as long as *claim*, last *heard* then, says; unless it may for longer already."""
        deadline = heard + claim.lasts
        if deadline > entry.deadline:
            entry.deadline, entry.expires = deadline, claim.seen_at.to_seconds() + claim.lasts
        self._set_deadline(entry)

    def _set_deadline(self, entry: Entry) -> None:
        forgets = self._forget_after if entry.freshness == "stale" else 0.0
        self._deadlines.set(entry.id, entry.deadline + forgets, None)

    def _store_value(self, entry: Entry, claim: SourceRecord, reading: Reading, told: StoredValue) -> None:
        """Make a new value findable, and tell it."""
        if told is NOT_ANNOUNCED:
            self.counters.unknown_parts += 1
            return
        is_sorted = entry.id not in self._unsorted
        if not (is_sorted or self.tells_states):
            return
        merged = entry.parts(self._disputed)
        number = merged.places.get((*claim.key, reading.part))
        if number is None:
            return
        part = merged.parts[number]
        if is_sorted and len(part.routes) > 1:
            self._unsorted[entry.id] = None
        elif is_sorted:
            self._postings.tell(entry.id, part.id, part.part.service_type, reading.capability, told.value)
        if self.tells_states:
            self._changes.note_state(entry, merged, state_of(part.id, reading, told))

    def _happen(self, entry: Entry, claim: SourceRecord, reading: Reading, stamp: Time) -> None:
        """Tell an event once, by however many routes it comes; it is no state, so nothing becomes findable by it."""
        if not has_capability(claim, reading.part, reading.capability):
            self.counters.unknown_parts += 1
            return
        merged = entry.parts(self._disputed)
        number = merged.places.get((*claim.key, reading.part))
        value = reading.value.plain()
        if number is None or not entry.is_new_event(number, reading.capability, value, claim.key, self._now):
            return
        told = StoredValue(value, stamp, stamp, live=True, heard=self._now)
        claim.events = {**claim.events, (reading.part, reading.capability): told}
        if self.tells_states:
            state = state_of(merged.parts[number].id, reading, told)
            self._changes.note_state(entry, merged, state)

    def _is_current(self, entry: Entry, parts: MergedParts, state: State) -> bool:
        if self._entries.get(entry.id) is not entry:
            return False
        if state.capability in EVENTS:
            return any(one.id == state.part for one in entry.parts(self._disputed).parts)
        if entry.parts(self._disputed) is parts:
            return True
        place = (state.part, state.capability)
        return any((one.part, one.capability) == place for one in self._device(entry).states)

    def _mark_unsaved(self, device_id: str) -> None:
        if self.is_saved:
            self.unsaved[device_id] = None
            if len(self.unsaved) > _MAX_UNSAVED:
                self.unsaved.clear()
                self.save_all()

    def _device(self, entry: Entry) -> Device:
        return entry.to_device(self._disputed)

    def _note(self, kind: ChangeKind, entry: Entry, why: str, other: str = "") -> None:
        entry.invalidate_device()
        self._unsorted[entry.id] = None
        self._changes.note(kind, entry, why, other)
