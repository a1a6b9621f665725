"""Reports before their announcement, and announcements of forgotten devices: they belong to no device now. Pure."""

from typing import final

from homebot.devices import Sighting
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.discovery.source_record import SourceKey
from homebot.messages import Time
from homebot.support.bounded_map import BoundedMap

__all__ = ["PendingReports"]

_MAX_KEYS = 1000
_MAX_FORGOTTEN = 10_000
_MAX_ADDRESSES = 16
_REPORT_WAIT = 60.0
"""Seconds for which a report is kept for its device: the two come on two topics, and either may be first."""

_EVENT_WAIT = 5.0
"""The same for an event: a press that is published a minute late opens a door after its visitor left."""


@final
class PendingReports:
    """The newest reports of the last thousand devices not announced yet, and the last sightings of forgotten ones."""

    def __init__(self) -> None:
        self.count = 0
        self._forgotten: BoundedMap[SourceKey, Sighting] = BoundedMap(_MAX_FORGOTTEN)
        self.reports: BoundedMap[SourceKey, BoundedMap[str, tuple[float, Report]]] = BoundedMap(_MAX_KEYS)

    def put(self, key: SourceKey, report: Report, now: float) -> None:
        """Keep *report*, which came at *now*; the newest of each stream."""
        self.count += 1
        found = self.reports[key] = self.reports.get(key) or BoundedMap(_MAX_ADDRESSES)
        found[report.stream] = now, report

    def remember_forgotten(self, key: SourceKey, sighting: Sighting) -> None:
        """Keep how a device that was forgotten is announced; the newest, of the last ten thousand."""
        self._forgotten[key] = sighting

    def revive(self, report: Report) -> Sighting | None:
        """Return the announcement of a device that was forgotten and is alive, as *report* shows; else None."""
        is_life = any(reading.capability != REACHABLE or reading.value.flag for reading in report.readings)
        if report.retained or not report.address or not is_life:
            return None
        sighting = self._forgotten.pop((report.gateway, report.key), None)
        if sighting is None:
            return None
        lasts = sighting.expires_at.to_seconds() - sighting.seen_at.to_seconds()
        expires_at = Time.from_seconds(report.received_at.to_seconds() + lasts)
        update = {"seen_at": report.received_at, "expires_at": expires_at, "confirmed": True}
        return sighting.model_copy(update={**update, "kind": "appeared", "why": "it reported again"})

    def pop(self, key: SourceKey, now: float) -> tuple[Report, ...]:
        """Return the reports of the device that is announced at *now*, oldest first, and forget them."""
        found = self.reports.pop(key, None)
        if found is None:
            return ()
        waits = ((now - came, report) for came, report in found.values())
        return tuple(one for age, one in waits if age <= (_EVENT_WAIT if _is_event(one) else _REPORT_WAIT))


def _is_event(report: Report) -> bool:
    return any(reading.capability in EVENTS for reading in report.readings)
