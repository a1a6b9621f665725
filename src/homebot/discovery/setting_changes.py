"""Changes of the settings of people and programs, gathered for subscribers without hurry. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Final, TypeAlias, final

from homebot.devices import DevicePart
from homebot.devices.capabilities import SETTABLE
from homebot.devices.device import ChangedSetting
from homebot.devices.value import Reading, Value
from homebot.discovery.device_table import DeviceTable
from homebot.discovery.entry import Entry
from homebot.discovery.search.columns import StoredValue
from homebot.discovery.source_record import SourceRecord
from homebot.messages import Time

__all__ = ["SettingChanges"]

_MOST: Final = 10_000
"""Changed settings that wait to be taken; further ones are dropped and counted as lost states."""

_Waiting: TypeAlias = tuple[Entry, SourceRecord, Reading, Time, StoredValue]
"""The device, its announcement, the first new value, since when it has had that, and where the newest one is kept."""


@final
class SettingChanges:
    """Settings that changed and were not taken yet; to record one that changed already costs nearly nothing.

    Attributes:
        waiting: Those that wait, by the identity of the stored value.
    """

    __slots__ = ("_table", "waiting")

    def __init__(self, table: DeviceTable) -> None:
        self._table = table
        self.waiting: dict[int, _Waiting] = {}

    def record(
        self, entry: Entry, source: SourceRecord, new: Iterable[tuple[tuple[str, str], Reading, StoredValue]]
    ) -> None:
        """Record the new live values of *source*, each with its part and capability, and where it is kept."""
        waiting = self.waiting
        for place, reading, stored in new:
            if place[1] not in SETTABLE or id(stored) in waiting:
                continue
            if len(waiting) < _MOST:
                waiting[id(stored)] = entry, source, reading, stored.since, stored
            else:
                self._table.changes.states_lost += 1

    def pop(self) -> Iterator[ChangedSetting]:
        """Yield the changes since the last time, as in `ChangedSettings`, and forget them."""
        table, waiting = self._table, self.waiting
        self.waiting = {}
        for entry, source, first, since, stored in waiting.values():
            if table.entries.get(entry.id) is not entry:
                continue
            part = entry.parts(table.topics).shown_part_of(source, first.part)
            if part is None:
                continue
            newest = stored.reported
            if newest is first.value or not (newest.number and first.value.number):
                yield _changed(entry, part, first.capability, first.value, since)
            if newest is not first.value:
                yield _changed(entry, part, first.capability, newest, stored.since)


def _changed(entry: Entry, part: DevicePart, capability: str, value: Value, at: Time) -> ChangedSetting:
    return ChangedSetting(device=entry.id, part=part.id, capability=capability, value=value, told_at=at)
