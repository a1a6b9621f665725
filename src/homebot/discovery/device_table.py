"""The devices, their announcements, and their pending updates. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, final

from homebot.devices.device import ChangeKind
from homebot.discovery.changes import ChangeQueue
from homebot.discovery.entry import Entry
from homebot.discovery.ids import Tombstones
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.search.postings import Postings
from homebot.discovery.source_record import LostLink, SourceKey, SourceRecord
from homebot.discovery.topics.ownership import TopicOwnership
from homebot.discovery.topics.use import topic_use
from homebot.support.counters import fault

if TYPE_CHECKING:
    from homebot.discovery.reading_limits import LimitsOfDevices

_MAX_UNSAVED = 200_000
"""Ids that may wait for an index file that cannot be written; beyond that, all known devices are written."""


@dataclass(slots=True)
class IndexCounters:
    """Counters of dropped and refused inputs.

    Attributes:
        rejected: Announcements of new devices while the index was full, or of a device with too many.
        retained_only: Retained announcements of forgotten devices.
        unknown_parts: Readings of unannounced parts or capabilities; they are ignored.
        outside_limits: Values outside the limits that the owner states; they are ignored.
    """

    rejected: int = fault()
    retained_only: int = 0
    unknown_parts: int = 0
    outside_limits: int = 0


@final
class DeviceTable:
    """The tables of the index, which merging, liveness, states and search share and change.

    Attributes:
        limits: The owner's limits of readings; None for none.
        lost: The lost links, by gateway.
        outdated: Ids of devices with outdated postings.
        panels: The identifiers of alarm panels.
        unsaved: Ids to be written to the index file, oldest first; also those of removed devices.
        is_saved: Whether there is an index file; without one, nothing is unsaved.
    """

    def __init__(self, first_sequence: int, owner: OwnerFacts) -> None:
        self.owner = owner
        self.sources: dict[SourceKey, SourceRecord] = {}
        self.owners: dict[SourceKey, Entry] = {}
        self.entries: dict[str, Entry] = {}
        self.limits: LimitsOfDevices | None = None
        self.lost: dict[str, LostLink] = {}
        self.tombstones = Tombstones()
        self.topics = TopicOwnership()
        self.changes = ChangeQueue(self.entries, self.topics, first_sequence)
        self.postings = Postings()
        self.outdated: dict[str, None] = {}
        self.panels: set[str] = set()
        self.unsaved: dict[str, None] = {}
        self.is_saved = False
        self.counters = IndexCounters()

    def record_change(
        self, kind: ChangeKind, entry: Entry, why: str, other: str = "", *, is_of_link: bool = False
    ) -> None:
        """Record a change of *entry*, whose message and postings are now out of date."""
        entry.device = None
        self.outdated[entry.id] = None
        self.changes.add(kind, entry, why, other, is_of_link=is_of_link)

    def judge_topics(self, entry: Entry) -> None:
        """Judge a dispute of the announcements of *entry* again: one was added, or the first value reported by one."""
        if self.topics.denied.keys().isdisjoint(entry.sources):
            return
        for source in entry.sources.values():
            self.topics.put(topic_use(source, entry.id))
        entry.invalidate_description()

    def drop(self, entry: Entry) -> None:
        """Remove *entry*, but not its announcements."""
        del self.entries[entry.id]
        self.outdated.pop(entry.id, None)
        self.postings.discard(entry.id)
        self.mark_unsaved(entry.id)
        if self.owner.groups is not None:
            self.owner.groups.discard(entry.id)
            self.regroup()

    def regroup(self) -> None:
        """Give each member of a gateway's group that changed its new facts."""
        groups = self.owner.groups
        if groups is None or not groups.has_changed:
            return
        groups.has_changed = False
        for entry in self.entries.values():
            if entry.is_regrouped(groups, self.topics):
                self.record_change("changed", entry, "its groups changed")

    def mark_unsaved(self, device_id: str) -> None:
        """Mark the record of the device as out of date."""
        if self.is_saved:
            self.unsaved[device_id] = None
            if len(self.unsaved) > _MAX_UNSAVED:
                self.unsaved.clear()
                self.mark_all_unsaved()

    def mark_all_unsaved(self) -> None:
        """Mark all records as out of date."""
        self.unsaved.update(dict.fromkeys(self.entries))
        self.unsaved.update((tombstone.id, None) for tombstone in self.tombstones)
