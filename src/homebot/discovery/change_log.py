"""The last changes of devices, for who asks later. Pure."""

from __future__ import annotations

from collections import deque

from homebot.devices import DeviceChange
from homebot.devices.part import size_of_parts, size_of_texts

__all__ = ["MAX_SIZE", "REMEMBERED", "ChangeLog"]

REMEMBERED = 2000
"""Changes that can still be asked for."""

MAX_SIZE = 16 * 1024 * 1024
"""Bytes of all, about: each change has the whole device in it, and those of a device that is gone are nowhere else."""

_CHANGE = 4096
"""Bytes of a change without its texts and parts, about."""

_PART = 1024
"""Bytes of a part without its lists, about."""


class ChangeLog:
    """Changes in the order of their coming; of too many, or too long ones, the oldest are forgotten.

    Args:
        first: Sequence number from which on it knows all.

    Attributes:
        forgotten: Sequence number of the last change that it does not have.
    """

    def __init__(self, first: int, most: int = REMEMBERED, max_size: int = MAX_SIZE) -> None:
        self.forgotten = first
        self._most = most
        self._max_size = max_size
        self._size = 0
        self._changes: deque[tuple[DeviceChange, int]] = deque()

    def append(self, change: DeviceChange) -> None:
        """Keep *change*, and forget what there is no more room for."""
        size = _size(change)
        self._changes.append((change, size))
        self._size += size
        while len(self._changes) > self._most or self._size > self._max_size:
            oldest, its_size = self._changes.popleft()
            self._size -= its_size
            self.forgotten = oldest.sequence

    def since(self, sequence: int) -> tuple[DeviceChange, ...]:
        """Return what came after the change with the number *sequence*, as far as it is known."""
        return tuple(one for one, _ in self._changes if one.sequence > sequence)

    def __len__(self) -> int:
        return len(self._changes)


def _size(change: DeviceChange) -> int:
    device = change.device
    facts = (text for fact in device.metadata for text in (fact.key, fact.value))
    texts = (device.name, device.area, change.why, *device.identifiers, *device.evidence, *device.conflicts, *facts)
    return _CHANGE + size_of_texts(texts) + size_of_parts(one.part for one in device.parts) + _PART * len(device.parts)
