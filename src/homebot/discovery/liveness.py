"""The liveness of devices: the silence that each is allowed, and those that exceed it. Pure."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, final

from homebot.messages import Time
from homebot.support.timer_queue import TimerQueue

if TYPE_CHECKING:
    from homebot.discovery.device_table import DeviceTable
    from homebot.discovery.entry import Entry
    from homebot.discovery.source_record import SourceRecord

SAVE_LIFE = 3600.0
"""Seconds between writes of when devices were last seen, together for all that report often: each write changes a whole
page of the file, and SD cards wear out."""

_ONLINE_FOR = 86_400.0
"""Seconds for which a device that reported itself online may be silent, as its last will would report its end."""


@final
class Liveness:
    """The deadlines of the devices: after one a device is stale, and *forget_after* later it is to be removed.

    Attributes:
        now: Time of the newest input, in seconds on the monotonic clock.
        deadlines: When :meth:`pop_silent` returns each device, in seconds on that clock.
    """

    def __init__(self, table: DeviceTable, forget_after: float) -> None:
        self.now = -math.inf
        self._table = table
        self._forget_after = forget_after
        self._stamp: Time | None = None
        self._seconds = 0.0
        self.deadlines: TimerQueue[str, None] = TimerQueue()

    def mark_seen(self, entry: Entry, source: SourceRecord, stamp: Time, why: str) -> None:
        """Record that *entry* itself has just reported through *source*, and so is fresh.

        Args:
            stamp: The time in seconds since the Unix epoch.
            why: The reason for the change if it was neither fresh nor stale.
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
        if stamp is not self._stamp:  # the same for everything received at once
            self._stamp, self._seconds = stamp, stamp.to_seconds()
        due, entry.deadline, entry.expires = entry.deadline, now + silence, self._seconds + silence
        if entry.is_shared:
            gateway = source.key[0]
            if before == "stale":
                entry.stale_gateways = entry.gateways() - {gateway}
            elif gateway in entry.stale_gateways:
                entry.stale_gateways -= {gateway}
                self._table.record_change("changed", entry, f"it reported again over {gateway}")
            self.schedule(entry)
        elif before != "fresh" or entry.deadline < due:  # a later deadline is checked when the earlier one has come
            self.deadlines.set(entry.id, entry.deadline, None)
        if before == "fresh":
            return
        self._table.outdated[entry.id] = None
        if before == "stale":
            self._table.record_change("returned", entry, "it reported again")
        else:
            self._table.record_change("changed", entry, why)

    def extend(self, entry: Entry, source: SourceRecord, heard_at: float) -> None:
        """Extend the deadline of *entry* by the silence that *source*, last heard at *heard_at*, allows."""
        silence = source.lasts
        deadline, before = heard_at + silence, entry.deadline
        if deadline > before:
            entry.deadline, entry.expires = deadline, source.seen_at.to_seconds() + silence
        if entry.is_shared or before == -math.inf:  # a later deadline is checked when the earlier one has come
            self.schedule(entry)

    def restart(self, entry: Entry, now: float, wall: float) -> None:
        """Let the allowed silence of a restored *entry* begin now."""
        silence = max(source.lasts for source in entry.sources.values())
        entry.deadline, entry.expires = now + silence, wall + silence
        self.deadlines.set(entry.id, entry.deadline, None)

    def schedule(self, entry: Entry) -> None:
        """Schedule the deadline of *entry*."""
        due = self._due(entry)
        if entry.is_shared and entry.freshness != "stale":
            due = min((due, *self._gateway_deadlines(entry).values()))
        self.deadlines.set(entry.id, due, None)

    def pop_silent(self, now: float) -> Entry | None:
        """Return a device that has been silent for too long at *now*, or None.

        If it is stale already, it is to be removed; otherwise to be marked as stale.
        """
        while (due := self.deadlines.pop(now)) is not None:
            entry = self._table.entries[due[0]]
            if self._due(entry) <= now:
                return entry
            if entry.is_shared:
                deadlines = self._gateway_deadlines(entry)
                silent = sorted(gateway for gateway, deadline in deadlines.items() if deadline <= now)
                entry.stale_gateways |= frozenset(silent)
                if silent:
                    self._table.record_change(
                        "changed", entry, f"it has been silent for too long over {', '.join(silent)}"
                    )
            self.schedule(entry)
        return None

    def mark_stale(self, entry: Entry) -> None:
        """Record that *entry* has been silent for too long at every gateway."""
        entry.freshness = "stale"
        self.schedule(entry)
        self._table.record_change("stale", entry, "it has been silent for too long")

    def _due(self, entry: Entry) -> float:
        """Return when *entry* becomes stale; if it is, when it is to be removed."""
        return entry.deadline + self._forget_after if entry.freshness == "stale" else entry.deadline

    def _gateway_deadlines(self, entry: Entry) -> dict[str, float]:
        """Return when *entry* becomes stale at each gateway that has heard it since the start, unless it is."""
        usual = entry.report_interval.expected_silence
        deadlines: dict[str, float] = {}
        for (gateway, _), source in entry.sources.items():
            if source.heard_at > -math.inf and gateway not in entry.stale_gateways:
                silence = max(source.lasts, usual, _ONLINE_FOR if source.is_online else 0.0)
                deadlines[gateway] = max(deadlines.get(gateway, -math.inf), source.heard_at + silence)
        return deadlines

    def forgotten_at(self, entry: Entry) -> float:
        """Return when a stale device is to be removed, in seconds since the Unix epoch."""
        return entry.expires + self._forget_after
