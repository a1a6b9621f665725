"""Liveness of devices: the silence of each that is no bad sign, and those that have been silent for too long. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, final

from homebot.messages import Time
from homebot.support.timer_queue import TimerQueue

if TYPE_CHECKING:
    from homebot.discovery.device_table import DeviceTable
    from homebot.discovery.entry import Entry
    from homebot.discovery.source_record import SourceRecord

__all__ = ["SAVE_LIFE", "Liveness"]


SAVE_LIFE = 3600.0
"""Seconds between two writings of when devices were last seen, of all that report often at once: each page that one of
them changes is written whole, and an SD card wears out."""

_ONLINE_FOR = 86_400.0
"""Seconds for which a device that reported live that it is online may be silent: its last will watches over it."""


@final
class Liveness:
    """Deadlines of the devices: after its own a device is stale, and after *forget_after* more it is overdue.

    Attributes:
        now: Time of the newest input, in seconds of a clock that is never set.
        deadlines: When :meth:`pop_silent` has which device, in seconds of that clock.
    """

    def __init__(self, table: DeviceTable, forget_after: float) -> None:
        self.now = -math.inf
        self._table = table
        self._forget_after = forget_after
        self._stamp: Time | None = None
        self._seconds = 0.0
        self.deadlines: TimerQueue[str, None] = TimerQueue()

    def mark_seen(self, entry: Entry, source: SourceRecord, stamp: Time, why: str) -> None:
        """Note that *entry* itself spoke now, through *source*: it is fresh.

        Args:
            stamp: The time in seconds since the Unix epoch.
            why: The reason to give where it was neither fresh nor stale.
        """
        now = self.now
        if (period := now // SAVE_LIFE) != entry.saved_period:
            entry.saved_period = period
            self._table.mark_unsaved(entry.id)
        source.confirmed = True
        source.seen_at, source.heard_at = stamp, now
        online_for = _ONLINE_FOR if source.is_online else 0.0
        silence = max(entry.report_interval.record(now), entry.silence_allowed, online_for)
        entry.device = None
        before, entry.freshness = entry.freshness, "fresh"
        if stamp is not self._stamp:  # all that is heard at once has one
            self._stamp, self._seconds = stamp, stamp.to_seconds()
        due, entry.deadline, entry.expires = entry.deadline, now + silence, self._seconds + silence
        if entry.is_shared:
            self._mark_gateway_seen(entry, source.key[0], was_stale=before == "stale")
        elif before != "fresh" or entry.deadline < due:  # a later one is seen when the one before has come
            self.deadlines.set(entry.id, entry.deadline, None)
        if before == "fresh":
            return
        self._table.outdated[entry.id] = None
        if before == "stale":
            self._table.record_change("returned", entry, "it reported again")
        else:
            self._table.record_change("changed", entry, why)

    def extend(self, entry: Entry, source: SourceRecord, heard_at: float) -> None:
        """Allow *entry* the silence that *source*, last heard at *heard_at*, allows; it may have a longer one."""
        silence = source.lasts
        deadline = heard_at + silence
        if deadline > entry.deadline:
            entry.deadline, entry.expires = deadline, source.seen_at.to_seconds() + silence
        self.schedule(entry)

    def restart(self, entry: Entry, now: float, wall: float) -> None:
        """Allow *entry*, which is known from before, its whole silence from now on."""
        silence = max(source.lasts for source in entry.sources.values())
        entry.deadline, entry.expires = now + silence, wall + silence
        self.deadlines.set(entry.id, entry.deadline, None)

    def schedule(self, entry: Entry) -> None:
        """Watch over the deadline of *entry*."""
        due = self._due(entry)
        if entry.is_shared and entry.freshness != "stale":
            due = min((due, *self._gateway_deadlines(entry).values()))
        self.deadlines.set(entry.id, due, None)

    def pop_silent(self, now: float) -> Entry | None:
        """Return a device that has been silent for too long at *now*; None if there is none.

        One that is stale is to be removed, any other to be marked as stale.
        """
        while (due := self.deadlines.pop(now)) is not None:
            entry = self._table.entries[due[0]]
            if self._due(entry) <= now:
                return entry
            if entry.is_shared:
                self._mark_gateways_stale(entry, now)
            else:
                self.schedule(entry)
        return None

    def mark_stale(self, entry: Entry) -> None:
        """Note that *entry* was silent for too long, at every gateway."""
        entry.freshness = "stale"
        self.schedule(entry)
        self._table.record_change("stale", entry, "it has been silent for too long")

    def _due(self, entry: Entry) -> float:
        """Return when *entry* is stale; where it is, when it is to be removed."""
        return entry.deadline + self._forget_after if entry.freshness == "stale" else entry.deadline

    def _gateway_deadlines(self, entry: Entry) -> dict[str, float]:
        """Return when *entry* is stale at each of its gateways that heard it since the start, and where it is not."""
        usual = entry.report_interval.expected_silence
        found: dict[str, float] = {}
        for (gateway, _), source in entry.sources.items():
            if source.heard_at > -math.inf and gateway not in entry.stale_gateways:
                silence = max(source.lasts, usual, _ONLINE_FOR if source.is_online else 0.0)
                found[gateway] = max(found.get(gateway, -math.inf), source.heard_at + silence)
        return found

    def _mark_gateway_seen(self, entry: Entry, gateway: str, *, was_stale: bool) -> None:
        """Note that *entry*, which several announcements are about, was heard at *gateway*."""
        if was_stale:
            entry.stale_gateways = entry.gateways() - {gateway}
        elif gateway in entry.stale_gateways:
            entry.stale_gateways -= {gateway}
            self._table.record_change("changed", entry, f"it reported again over {gateway}")
        self.schedule(entry)

    def _mark_gateways_stale(self, entry: Entry, now: float) -> None:
        """Note at which gateways *entry* was silent for too long at *now*; at others it was not."""
        silent = sorted(gateway for gateway, due in self._gateway_deadlines(entry).items() if due <= now)
        entry.stale_gateways |= frozenset(silent)
        if silent:
            self._table.record_change("changed", entry, f"it has been silent for too long over {', '.join(silent)}")
        self.schedule(entry)

    def forgotten_at(self, entry: Entry) -> float:
        """Return when a stale device is to be removed, in seconds since the Unix epoch."""
        return entry.expires + self._forget_after
