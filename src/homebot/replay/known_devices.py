"""Devices that the directory knows at the start of a replay, as rows of its index. Pure.

Devices that appear in the recording are among them, as removed ones: the id of a new device is made of its first
announcement, and of several announcements of one moment the directory may get the last alone. So a replay could choose
another id.
"""

from __future__ import annotations

from homebot.devices.services import IndexRow
from homebot.discovery.ids import Tombstone
from homebot.discovery.record import read_entry, read_tombstone, tombstone_record
from homebot.errors import UsageError, WireError
from homebot.recording.recording import Recording

__all__ = ["check_index", "ids_to_come"]


def check_index(recording: Recording) -> None:
    """Read the rows of the index.

    Raises:
        UsageError: One is damaged; the directory would go on without the device.
    """
    for row in recording.index:
        try:
            if row.table == "devices":
                read_entry(row.id, row.record)
            elif row.table == "tombstones":
                read_tombstone(row.id, row.record)
        except WireError as exc:
            raise UsageError(f"the recording is damaged: the row {row.id[:100]!r} of its index: {exc.problem}") from exc


def ids_to_come(recording: Recording) -> tuple[IndexRow, ...]:
    """Return the devices that are not in the index at the start as such that went, and get their ids when they return.

    An announcement counts for its first device, so that devices split from it get the same ids as before.
    """
    known = {row.id for row in recording.index}
    taken: set[tuple[str, str]] = set()
    rows: list[IndexRow] = []
    for device in recording.devices.values():
        keys = tuple((one.gateway, one.key) for one in device.endpoints if (one.gateway, one.key) not in taken)
        taken.update(keys)
        if keys and device.id not in known:
            gone = Tombstone(device.id, keys, (), retained_only=False, at=recording.header.started_at.to_seconds())
            rows.append(IndexRow(table="tombstones", id=device.id, record=tombstone_record(gone)))
    return tuple(rows)
