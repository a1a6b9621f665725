"""Devices, the announcements they consist of, and what is to be brought up to date about each. Pure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from homebot.devices.device import ChangeKind
from homebot.discovery.change_queue import ChangeQueue
from homebot.discovery.entry import Entry
from homebot.discovery.ids import Tombstones
from homebot.discovery.search.postings import Postings
from homebot.discovery.source_record import SourceKey, SourceRecord
from homebot.discovery.topics.ownership import TopicOwnership
from homebot.discovery.unsaved import UnsavedDevices

__all__ = ["DeviceTable", "IndexCounters"]


@dataclass(slots=True)
class IndexCounters:
    """Numbers of what was not taken in.

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

    Args:
        first_sequence: Number of the first change.

    Attributes:
        sources: Announcements by gateway and key.
        owners: The device of each announcement.
        entries: Devices by id.
        tombstones: Devices that went.
        topics: Which announcement may use which command topic.
        changes: Changes that were not taken yet.
        postings: What devices can be found by.
        outdated: Ids of the devices whose postings are out of date.
        unsaved: Ids of the devices whose record in the index file is out of date.
        counters: What was not taken in.
        collects_states: Whether changes of states are collected.
    """

    __slots__ = (
        "changes",
        "collects_states",
        "counters",
        "entries",
        "outdated",
        "owners",
        "postings",
        "sources",
        "tombstones",
        "topics",
        "unsaved",
    )

    def __init__(self, first_sequence: int) -> None:
        self.sources: dict[SourceKey, SourceRecord] = {}
        self.owners: dict[SourceKey, Entry] = {}
        self.entries: dict[str, Entry] = {}
        self.tombstones = Tombstones()
        self.topics = TopicOwnership()
        self.changes = ChangeQueue(self.entries, self.topics, first_sequence)
        self.postings = Postings()
        self.outdated: dict[str, None] = {}
        self.unsaved = UnsavedDevices(self.entries, self.tombstones)
        self.counters = IndexCounters()
        self.collects_states = False

    def note(self, kind: ChangeKind, entry: Entry, why: str, other: str = "") -> None:
        """Note a change of *entry*, which makes its message and its postings out of date."""
        entry.invalidate_device()
        self.outdated[entry.id] = None
        self.changes.note(kind, entry, why, other)

    def drop(self, entry: Entry) -> None:
        """Remove *entry*, but not its announcements."""
        del self.entries[entry.id]
        self.outdated.pop(entry.id, None)
        self.postings.discard(entry.id)
        self.unsaved.add(entry.id)
