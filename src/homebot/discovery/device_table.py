"""Devices, the announcements they consist of, and the pending updates of each. Pure."""

from dataclasses import dataclass
from typing import final

from homebot.devices.device import ChangeKind
from homebot.discovery.changes import ChangeQueue
from homebot.discovery.entry import Entry
from homebot.discovery.ids import Tombstones
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.search.postings import Postings
from homebot.discovery.source_record import LostLink, SourceKey, SourceRecord
from homebot.discovery.topics.ownership import TopicOwnership

__all__ = ["DeviceTable", "IndexCounters"]

_MAX_UNSAVED = 200_000
"""Ids that wait for an index file that cannot be written; those that are known now then take their place."""


@dataclass(slots=True)
class IndexCounters:
    """Numbers of dropped and refused inputs.

    Attributes:
        rejected: Announcements of new devices while the index was full, and those of a device that has too many.
        retained_only: Announcements that the broker had kept, of devices that were forgotten.
        unknown_parts: Readings of parts that were not announced, or not with that capability; they change nothing.
    """

    rejected: int = 0
    retained_only: int = 0
    unknown_parts: int = 0


@final
class DeviceTable:
    """The tables of the index, shared by merging, liveness, states and search, which each change their part of them.

    Attributes:
        lost: The loss of the link of each gateway that has none.
        outdated: Ids of the devices with outdated postings.
        unsaved: Ids to be written to the index file, those of devices that went as well, oldest first.
        is_saved: Whether there is an index file; without one nothing is unsaved.
    """

    def __init__(self, first_sequence: int, owner: OwnerFacts) -> None:
        self.owner = owner
        self.sources: dict[SourceKey, SourceRecord] = {}
        self.owners: dict[SourceKey, Entry] = {}
        self.entries: dict[str, Entry] = {}
        self.lost: dict[str, LostLink] = {}
        self.tombstones = Tombstones()
        self.topics = TopicOwnership()
        self.changes = ChangeQueue(self.entries, self.topics, first_sequence)
        self.postings = Postings()
        self.outdated: dict[str, None] = {}
        self.unsaved: dict[str, None] = {}
        self.is_saved = False
        self.counters = IndexCounters()

    def record_change(
        self, kind: ChangeKind, entry: Entry, why: str, other: str = "", *, is_of_link: bool = False
    ) -> None:
        """Record a change of *entry*, which makes its message and its postings out of date."""
        entry.device = None
        self.outdated[entry.id] = None
        self.changes.add(kind, entry, why, other, is_of_link=is_of_link)

    def drop(self, entry: Entry) -> None:
        """Remove *entry*, but not its announcements."""
        del self.entries[entry.id]
        self.outdated.pop(entry.id, None)
        self.postings.discard(entry.id)
        self.mark_unsaved(entry.id)

    def mark_unsaved(self, device_id: str) -> None:
        """Note that the record of the device is out of date."""
        if self.is_saved:
            self.unsaved[device_id] = None
            if len(self.unsaved) > _MAX_UNSAVED:
                self.unsaved.clear()
                self.mark_all_unsaved()

    def mark_all_unsaved(self) -> None:
        """Note that no record is up to date."""
        self.unsaved.update(dict.fromkeys(self.entries))
        self.unsaved.update((tombstone.id, None) for tombstone in self.tombstones)
