"""Reports without a device: those before their announcement, and those of forgotten devices. Pure."""

from typing import final

from homebot.devices import Sighting
from homebot.devices.capabilities import EVENTS
from homebot.devices.gateway_messages import REACHABLE, Report
from homebot.discovery.source_record import SourceKey
from homebot.messages import Time
from homebot.support.bounded_map import BoundedMap

_MAX_KEYS = 1000
_MAX_FORGOTTEN = 10_000
_MAX_ADDRESSES = 16
_REPORT_WAIT = 60.0
"""Seconds for which a report waits for its announcement, which comes on another topic and may be later."""

_EVENT_WAIT = 5.0
"""The same for an event: a press published a minute late would open a door after the visitor left."""


@final
class PendingReports:
    """The newest reports of up to 1,000 unannounced devices, and the last sightings of forgotten ones."""

    def __init__(self) -> None:
        self.count = 0
        self._forgotten: BoundedMap[SourceKey, Sighting] = BoundedMap(_MAX_FORGOTTEN)
        self.reports: BoundedMap[SourceKey, BoundedMap[str, tuple[float, Report]]] = BoundedMap(_MAX_KEYS)

    def put(self, key: SourceKey, report: Report, now: float) -> None:
        """Keep *report*, received at *now*; only the newest of each stream."""
        self.count += 1
        by_stream = self.reports[key] = self.reports.get(key) or BoundedMap(_MAX_ADDRESSES)
        by_stream[report.stream] = now, report

    def remember_forgotten(self, key: SourceKey, sighting: Sighting) -> None:
        """Keep the newest announcement of a forgotten device; at most 10,000."""
        self._forgotten[key] = sighting

    def revive(self, report: Report) -> Sighting | None:
        """Return the announcement of a forgotten device that *report* shows to be alive, or None."""
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
        """Remove and return the reports of a device announced at *now*, oldest first."""
        reports = self.reports.pop(key, None)
        if reports is None:
            return ()
        waits = ((now - came, report) for came, report in reports.values())
        return tuple(report for age, report in waits if age <= (_EVENT_WAIT if _is_event(report) else _REPORT_WAIT))


def _is_event(report: Report) -> bool:
    return any(reading.capability in EVENTS for reading in report.readings)
