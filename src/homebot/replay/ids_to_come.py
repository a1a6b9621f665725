"""Ids of the devices that appear in a recording, as rows of the directory's index. Pure.

The id of a new device is made of what the directory heard of it first. Of several announcements of one moment it may
hear the last alone, so a replay could give it another id.
"""

from __future__ import annotations

from homebot.devices.services import IndexRow
from homebot.discovery.ids import Tombstone
from homebot.discovery.record import tombstone_record
from homebot.recording.recording import Recording

__all__ = ["ids_to_come"]


def ids_to_come(recording: Recording) -> tuple[IndexRow, ...]:
    """Return the devices that are not in the index at the start as such that went, and get their ids when they return.

    An announcement counts for the first device that had it: what was split from that gets its id as it did then.
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
