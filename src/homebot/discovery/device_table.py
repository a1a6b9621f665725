"""Devices, the announcements they consist of, and the pending updates of each. Pure."""

from __future__ import annotations

from collections.abc import Iterable
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

__all__ = ["DeviceTable", "IndexCounters", "UnsavedDevices"]


_MAX_UNSAVED = 200_000


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
        entries: Devices by id.
        lost: The loss of the link of each gateway that has none.
        outdated: Ids of the devices with outdated postings.
        unsaved: Ids of the devices with an outdated record in the index file.
    """

    __slots__ = (
        "changes",
        "counters",
        "entries",
        "lost",
        "outdated",
        "owner",
        "owners",
        "postings",
        "sources",
        "tombstones",
        "topics",
        "unsaved",
    )

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
        self.unsaved = UnsavedDevices(self.entries, self.tombstones)
        self.counters = IndexCounters()

    def record_change(
        self, kind: ChangeKind, entry: Entry, why: str, other: str = "", *, is_of_link: bool = False
    ) -> None:
        """Record a change of *entry*, which makes its message and its postings out of date."""
        entry.invalidate_device()
        self.outdated[entry.id] = None
        self.changes.add(kind, entry, why, other, is_of_link=is_of_link)

    def drop(self, entry: Entry) -> None:
        """Remove *entry*, but not its announcements."""
        del self.entries[entry.id]
        self.outdated.pop(entry.id, None)
        self.postings.discard(entry.id)
        self.unsaved.add(entry.id)


@final
class UnsavedDevices:
    """Ids to be written to the index file, those of devices that went as well.

    If nothing is written for so long that 200,000 wait, those that are known now take their place.

    Args:
        known: Ids of the devices that are known.

    Attributes:
        is_enabled: Whether there is an index file; without one nothing is noted.
        ids: Those that wait, oldest first.
    """

    __slots__ = ("_known", "_tombstones", "ids", "is_enabled")

    def __init__(self, known: Iterable[str], tombstones: Tombstones) -> None:
        self.is_enabled = False
        self.ids: dict[str, None] = {}
        self._known = known
        self._tombstones = tombstones

    def add(self, device_id: str) -> None:
        """Note that the record of the device is out of date."""
        if self.is_enabled:
            self.ids[device_id] = None
            if len(self.ids) > _MAX_UNSAVED:
                self.ids.clear()
                self.add_all()

    def add_all(self) -> None:
        """Note that no record is up to date."""
        self.ids.update(dict.fromkeys(self._known))
        self.ids.update((tombstone.id, None) for tombstone in self._tombstones)
