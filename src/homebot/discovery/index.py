"""The index: the devices, their services, and how fresh that knowledge is. Pure: callers pass the time.

A device is one entry, whatever its number of messages, announcements and addresses. Changes of devices are collected
until :meth:`DeviceIndex.pop_changes`, so that a device that is announced in thirty messages is published once.

Times called *now* are in seconds on the monotonic clock; *wall* is in seconds since the Unix epoch.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, final

from homebot.devices import Device
from homebot.devices.health import Count
from homebot.devices.query.facets import facets_of
from homebot.devices.query.terms import Query, type_is
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.device_table import IndexCounters as IndexCounters
from homebot.discovery.entry import Entry
from homebot.discovery.liveness import Liveness
from homebot.discovery.merging.intake import SightingIntake
from homebot.discovery.merging.merger import DeviceMerger
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.pending import PendingReports
from homebot.discovery.search.postings import PostedValue
from homebot.discovery.states import SettingChanges, StateRecorder
from homebot.support.counters import Severity

if TYPE_CHECKING:
    from homebot.discovery.places_editor import PlacesEditor
    from homebot.discovery.places_exchange import PlacesExchange

MAX_DEVICES = 100_000


@final
class DeviceIndex:
    """Every known device, kept up to date by sightings, reports and the passing of time.

    Args:
        forget_after: Seconds for which a stale device stays in the index before it is removed.
        first_sequence: Number of the first change, above those of an earlier index.

    Attributes:
        changes: The changes to be published, and the last published ones.
        pop_states: Its :meth:`ChangeQueue.pop_states`; to be called after *pop_changes*.
        postings: Postings for finding devices; up to date after :meth:`sort`.
        deadlines: When :meth:`expire` has work to do, in seconds on its clock.
        next_deadline: Returns the first deadline; None for never.
        decisions: The owner's decisions on which announcements are one device, for the index file.
        observe, report: Those of :class:`SightingIntake`.
        split, merge: Those of :class:`DeviceMerger`.
        record_link: That of :class:`StateRecorder`.
    """

    def __init__(
        self,
        *,
        forget_after: float,
        first_sequence: int = 1,
        max_devices: int = MAX_DEVICES,
        owner: OwnerFacts | None = None,
    ) -> None:
        table = self.table = DeviceTable(first_sequence, owner or OwnerFacts())
        self.counters, self.tombstones, self.owner = table.counters, table.tombstones, table.owner
        self.changes, self.postings = table.changes, table.postings
        self.pop_changes, self.pop_states = table.changes.pop, table.changes.pop_states
        self._pending = PendingReports()
        self._liveness = Liveness(table, forget_after)
        self.deadlines = self._liveness.deadlines
        self.next_deadline = self.deadlines.next
        self._merger = DeviceMerger(table, self._liveness, self._pending)
        self.decisions, self.split, self.merge = self._merger.decisions, self._merger.split, self._merger.merge
        self.settings = SettingChanges(table)
        states = StateRecorder(table, self._liveness, self._merger.trust, self.settings)
        self.record_link = states.record_link
        self._intake = SightingIntake(table, self._liveness, self._merger, states, self._pending, max_devices)
        self.observe, self.report = self._intake.observe, self._intake.report

    def __len__(self) -> int:
        return len(self.table.entries)

    def counts(self) -> tuple[Count, ...]:
        """Return the numbers of refused and dropped inputs."""
        return (
            *Count.of(self.counters),
            Count(name="strays", count=self._pending.count),
            Count(name="identifiers_cut", count=self._merger.identities.cut, severity=Severity.FAULT),
            Count(name="states_lost", count=self.changes.states_lost, severity=Severity.LOSS),
        )

    @property
    def ids(self) -> tuple[str, ...]:
        """The ids of all devices, including removed ones."""
        return tuple(dict.fromkeys((*self.table.entries, *(tombstone.id for tombstone in self.tombstones))))

    @property
    def sequence(self) -> int:
        """Number of the last change that was popped."""
        return self.changes.sequence

    def expire(self, now: float, at_most: int | None = None) -> int:
        """Mark devices that have been silent for too long as stale, and remove those that have been stale for too long.

        Args:
            now: Seconds on the monotonic clock, so that setting the computer's clock makes nothing stale.
            at_most: Most changes to make; None for no limit.

        Returns:
            The number of changes made; call again until it is 0.
        """
        made = 0
        while (at_most is None or made < at_most) and (entry := self._liveness.pop_silent(now)) is not None:
            made += 1
            if entry.freshness == "stale":
                at = self._liveness.forgotten_at(entry)
                self._merger.remove(entry, "it has been stale for too long", retained_only=True, at=at)
            else:
                self._liveness.mark_stale(entry)
        return made

    @property
    def is_behind(self) -> bool:
        """True if changes or postings are waiting."""
        return bool(self.changes.pending or self.changes.states or self.table.outdated)

    def devices(self, service_type: str = "") -> tuple[Device, ...]:
        """Return the devices that offer *service_type*, sorted by id; all devices if it is empty."""
        entries = self.table.entries
        ids = self.find(type_is(service_type)) if service_type else entries
        return tuple(entries[device_id].to_device(self.table.topics) for device_id in sorted(ids))

    def get(self, device_id: str) -> Device | None:
        """Return the device *device_id*, or None."""
        entry = self.table.entries.get(device_id)
        return entry.to_device(self.table.topics) if entry is not None else None

    def find(self, query: Query) -> frozenset[str] | set[str]:
        """Return the ids of the devices that match *query*, as a set not to be modified."""
        if self.table.outdated:
            self.sort()
        return self.table.postings.find(query)

    def sort(self, at_most: int | None = None) -> bool:
        """Update the postings of at most so many changed devices; return whether some are left.

        :meth:`find` does so itself, but answers sooner if it was done before.
        """
        table = self.table
        outdated, topics = table.outdated, table.topics
        done = 0
        while outdated and (at_most is None or done < at_most):
            device_id = next(iter(outdated))
            del outdated[device_id]
            entry = table.entries[device_id]
            device = entry.to_device(topics)
            facets = facets_of(device)
            if "group" in facets.categories or table.owner.groups is not None:
                table.owner.any_groups().put(device)
            values: list[PostedValue] = []
            if device.states:
                newest = zip(facets.values, entry.newest_values(topics), strict=True)
                values = [(part, kind, name, stored) for (kind, name, _, part), stored in newest]
            table.postings.put(facets, values)
            done += 1
            if not outdated and table.owner.groups is not None:
                table.regroup()
        return bool(outdated)

    def forget(self, device_id: str, now: float) -> tuple[tuple[str, str], ...] | None:
        """Remove the device; its own messages bring it back, retained announcements do not.

        Args:
            now: Seconds since the Unix epoch, for the tombstone.

        Returns:
            Gateway and topic of its announcements; None if there is no such device.
        """
        entry = self.table.entries.get(device_id)
        if entry is None:
            return None
        sightings = [source.sighting for source in entry.sources.values()]
        self._merger.remove(entry, "it was forgotten on request", retained_only=True, at=now)
        return tuple((sighting.gateway, sighting.announced_on) for sighting in sightings if sighting.announced_on)

    @property
    def places(self) -> PlacesEditor:
        """The editor of the rooms, aliases and tags that the owner states."""
        from homebot.discovery.places_editor import PlacesEditor  # noqa: PLC0415 - with the first statement

        return PlacesEditor(self.table)

    @property
    def places_exchange(self) -> PlacesExchange:
        """The export and import of the owner's statements."""
        from homebot.discovery.places_exchange import PlacesExchange  # noqa: PLC0415 - with the first file

        return PlacesExchange(self.table, self.places)

    def entry(self, device_id: str) -> Entry | None:
        """Return the entry of the device, for the index file."""
        entry = self.table.entries.get(device_id)
        if entry is not None:
            entry.parts(self.table.topics)  # so that new parts have their ids
        return entry

    def restore(self, entry: Entry, now: float, wall: float | None = None) -> None:
        """Add a device of the index file, unconfirmed, before any other input.

        Args:
            now: Seconds on the clock of :meth:`expire`. The time to expiry begins now, as how long homebot was down is
                unknown if the clock was set meanwhile.
            wall: Seconds since the Unix epoch, for its stamp; by default *now*.
        """
        self._intake.restore(entry, now, now if wall is None else wall)
