"""The intake of sightings and reports, which add, update, confirm or withdraw announcements. Pure."""

from typing import final

from homebot.devices import Sighting
from homebot.devices.gateway_messages import Report
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.liveness import Liveness
from homebot.discovery.merging.merger import DeviceMerger
from homebot.discovery.pending import PendingReports
from homebot.discovery.source_record import SourceKey, SourceRecord, is_described_anew, record_description
from homebot.discovery.states import StateRecorder

MAX_SOURCES = 1000
"""Most announcements of one device; further ones are rejected."""

_SOURCES_PER_DEVICE = 10
"""Most announcements in the index, per device that it may hold."""


@final
class SightingIntake:
    """Applies sightings and reports to the index."""

    def __init__(
        self,
        table: DeviceTable,
        liveness: Liveness,
        merger: DeviceMerger,
        states: StateRecorder,
        pending: PendingReports,
        max_devices: int,
    ) -> None:
        self._table = table
        self._liveness = liveness
        self._merger = merger
        self._states = states
        self._pending = pending
        self._max_devices = max_devices
        self._number = 0
        self._restored: set[SourceKey] = set()  # not announced since the start

    def observe(self, sighting: Sighting, now: float | None = None) -> None:
        """Apply *sighting*.

        Args:
            now: The time on the monotonic clock of :meth:`DeviceIndex.expire`; by default the sighting's stamp, as for
                a recording.
        """
        self._liveness.now = sighting.seen_at.to_seconds() if now is None else now
        key = (sighting.gateway, sighting.key)
        source = self._table.sources.get(key)
        if sighting.kind == "removed":
            if source is not None:
                self._withdraw(key, sighting.why)
        elif source is not None:
            self._refresh(source, sighting)
        elif not self._table.tombstones.by_id or not self._is_forgotten(key, sighting):
            self._add(key, sighting)

    def report(self, report: Report, now: float | None = None) -> None:
        """Apply the report of a device; that of an unannounced device waits a moment, and is counted."""
        self._liveness.now = report.received_at.to_seconds() if now is None else now
        key = (report.gateway, report.key)
        source = self._table.sources.get(key)
        if source is None and (sighting := self._pending.revive(report)) is not None:
            self._add(key, sighting)
            source = self._table.sources.get(key)
        if source is None:
            self._pending.put(key, report, self._liveness.now)
        else:
            self._states.record(self._table.owners[key], source, report)

    def _add(self, key: SourceKey, sighting: Sighting) -> None:
        """Add a new announcement, unless it is rejected, and apply the reports that waited for it."""
        table, merger = self._table, self._merger
        if len(table.sources) >= _SOURCES_PER_DEVICE * self._max_devices:
            table.counters.rejected += 1
            return
        source = SourceRecord(
            sighting=sighting,
            number=0,
            first_seen=sighting.seen_at,
            seen_at=sighting.seen_at,
            confirmed=sighting.confirmed,
            heard_at=self._liveness.now,
            lost=table.lost.get(sighting.gateway),
        )
        key = source.key  # one object everywhere
        affected = merger.identities.put(key, sighting)
        sibling = merger.identities.same_identity(key)
        count = len(table.owners[sibling].sources) + 1 if sibling is not None else len(affected)
        if count > MAX_SOURCES or (count == 1 and len(table.entries) >= self._max_devices):
            merger.identities.discard(key)
            table.counters.rejected += 1
            return
        self._number += 1
        table.changes.announced += 1
        table.sources[key] = source
        self._restored.discard(key)
        source.number = self._number
        is_overtaken = sighting.kind == "updated" and sighting.announced_on
        why = "it was announced" if is_overtaken else sighting.why
        if count == 1:
            merger.appear({key: source}, why)
            merger.join_repetitions(key)
        else:
            if sibling is not None:  # it has the same identity
                self._merger.join(self._table.owners[sibling], source, sibling)
            else:
                self._merger.regroup(affected, why)
            self._merger.join_repetitions(source.key)
            if source.confirmed:
                self._liveness.mark_seen(self._table.owners[source.key], source, source.seen_at, why)
        if key in self._pending.reports:
            now = self._liveness.now
            for report in self._pending.pop(key, now):
                self.report(report, now)

    def _is_forgotten(self, key: SourceKey, sighting: Sighting) -> bool:
        """Return whether *sighting* is only a retained one of a forgotten device; if so, remember it."""
        table = self._table
        tombstone = table.tombstones.find(key, ())
        if tombstone is None or not tombstone.retained_only or sighting.confirmed:
            return False
        table.counters.retained_only += 1
        self._pending.remember_forgotten(key, sighting)
        return True

    def _refresh(self, source: SourceRecord, sighting: Sighting) -> None:
        """Apply a further sighting of a known announcement."""
        table, key = self._table, source.key
        before, source.sighting = source.sighting, sighting
        entry = table.owners[key]
        if is_described_anew(before, sighting):
            table.changes.announced += 1
            record_description(source, before)
            if affected := self._merger.identities.put(key, sighting):
                self._merger.regroup(affected, "its identifiers changed")
                entry = table.owners[key]
            self._merger.describe(entry)
            table.record_change("changed", entry, "its description changed")
            self._merger.join_repetitions(key)
            entry = table.owners[key]
        if sighting.confirmed:
            self._liveness.mark_seen(entry, source, sighting.seen_at, "it sent a message")
        elif not source.confirmed and entry.freshness == "unconfirmed":
            source.seen_at, source.heard_at = sighting.seen_at, self._liveness.now
            entry.device = None
            self._liveness.extend(entry, source, self._liveness.now)
        self._restored.discard(key)
        if self._restored and sighting.native:
            self._withdraw_derived(entry, sighting)

    def _withdraw(self, key: SourceKey, why: str) -> None:
        """Remove a known announcement, and its device with the last one."""
        self._restored.discard(key)
        entry = self._table.owners[key]
        if len(entry.sources) == 1:
            self._merger.remove(entry, why, retained_only=False, at=entry.last_seen().to_seconds())
        else:
            self._merger.withdraw(entry, key, why)

    def _withdraw_derived(self, entry: Entry, listed: Sighting) -> None:
        """Remove announcements of an earlier run by the program that now lists the device instead."""
        origin = next((item for item in listed.metadata if item.key == "origin"), None)
        for key in [key for key in entry.sources if key in self._restored and key[0] == listed.gateway]:
            known = self._table.sources[key].sighting
            is_alike = not known.native and origin in known.metadata
            if is_alike and any(part.is_below(listed.owns) for part in known.parts):
                self._withdraw(key, "the list of its bridge describes it")

    def restore(self, entry: Entry, now: float, wall: float) -> None:
        """Add a device of the index file, unless it is already known or there are too many."""
        table = self._table
        if entry.id in table.entries or len(table.entries) >= self._max_devices or not entry.sources:
            return
        if any(key in table.sources for key in entry.sources):
            return
        for key, source in entry.sources.items():
            self._number += 1
            source.number = self._number
            source.lost = table.lost.get(key[0])
            table.sources[key] = source
        self._restored |= entry.sources.keys()
        self._merger.restore(entry, now, wall)
        for key in entry.sources:
            self._merger.join_repetitions(key)
