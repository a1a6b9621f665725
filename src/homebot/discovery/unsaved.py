"""Devices whose record in the index file is out of date. Pure."""

from __future__ import annotations

from collections.abc import Iterable
from typing import final

from homebot.discovery.ids import Tombstones

__all__ = ["UnsavedDevices"]

_MAX_UNSAVED = 200_000


@final
class UnsavedDevices:
    """Ids to be written to the index file, those of devices that went as well.

    Should nobody write for so long that 200,000 wait, those that are known now take their place.

    Args:
        known: Ids of the devices that are known.
        tombstones: Devices that went.

    Attributes:
        is_enabled: Whether there is an index file; without one nothing is noted.
        ids: Those that wait, oldest first.
    """

    __slots__ = ("_known", "_tombstones", "ids", "is_enabled")

    def __init__(self, known: Iterable[str], tombstones: Tombstones) -> None:
        self.is_enabled = False
        self.ids: dict[str, None] = {}
        self._known = known
        self._tombstones = tombstones

    def add(self, device_id: str) -> None:
        """Note that the record of the device is out of date."""
        if self.is_enabled:
            self.ids[device_id] = None
            if len(self.ids) > _MAX_UNSAVED:
                self.ids.clear()
                self.add_all()

    def add_all(self) -> None:
        """Note that no record is up to date."""
        self.ids.update(dict.fromkeys(self._known))
        self.ids.update((stone.id, None) for stone in self._tombstones)
