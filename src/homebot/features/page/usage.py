"""Counts of people's commands by day, device and hour of the day."""

from collections.abc import MutableMapping
from datetime import datetime, timedelta, tzinfo
from typing import Any, Final, final

from homebot.devices.client_rights import is_from_person
from homebot.devices.journal_messages import JournalEntry
from homebot.features.page.messages import DeviceUsage, UsageResponse

_DAYS: Final = 28
_MAX_DEVICES: Final = 500
"""The limit of devices in a day, and in an answer."""

_LOST: Final = ""
"""The key, in place of a device's id, of the commands that were not counted."""


@final
class Usage:
    """Counts commands, for 28 days; those to more than 500 devices in a day are only counted as lost.

    Args:
        days: The counts that are kept, by day as ``2026-11-29``, device and hour.
        zone: The time zone of the home; None for the computer's.
    """

    def __init__(self, days: MutableMapping[str, Any], zone: tzinfo | None) -> None:
        self._days = days
        self._zone = zone

    def add(self, entry: JournalEntry) -> None:
        """Count *entry* if it is a command of a person."""
        if entry.kind != "requested" or not is_from_person(entry.issuer, entry.trigger):
            return
        at = datetime.fromtimestamp(entry.at.to_seconds(), self._zone)
        day, oldest = at.date().isoformat(), (at.date() - timedelta(days=_DAYS - 1)).isoformat()
        for old in [known for known in self._days if known < oldest]:
            del self._days[old]
        counts: dict[str, dict[str, int]] = self._days.get(day, {})
        device = entry.device if entry.device in counts or len(counts) < _MAX_DEVICES else _LOST
        hours = counts.get(device, {})
        hour = str(at.hour)
        self._days[day] = {**counts, device: {**hours, hour: hours.get(hour, 0) + 1}}

    def answer(self, now: float) -> UsageResponse:
        """Return the use of devices in the 28 days before *now*, in seconds since the Unix epoch."""
        today = datetime.fromtimestamp(now, self._zone).date()
        oldest = (today - timedelta(days=_DAYS - 1)).isoformat()
        totals: dict[str, list[int]] = {}
        for day, counts in self._days.items():
            for device, hours in counts.items() if day >= oldest else ():
                total = totals.setdefault(device, [0] * 24)
                for hour, count in hours.items():
                    total[int(hour)] += count
        totals.pop(_LOST, None)
        most = sorted(totals.items(), key=lambda row: (-sum(row[1]), row[0]))[:_MAX_DEVICES]
        lost = sum(self._days.get(today.isoformat(), {}).get(_LOST, {}).values())
        return UsageResponse(
            devices=tuple(DeviceUsage(device=device, hours=tuple(hours)) for device, hours in most), lost=lost
        )
