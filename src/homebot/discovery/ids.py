"""The ids that devices get, and the memory of those that went. Pure."""

from __future__ import annotations

import re
from collections import OrderedDict
from collections.abc import Container, Iterable, Iterator
from dataclasses import dataclass
from hashlib import blake2b
from typing import final

from homebot.devices import Sighting
from homebot.devices.query.folding import fold
from homebot.discovery.source_record import SourceKey

__all__ = ["MAX_TOMBSTONES", "Tombstone", "Tombstones", "new_id"]

MAX_TOMBSTONES = 10_000
"""Devices that went and are remembered; the oldest is forgotten."""

_LONGEST_SLUG = 60
_SHORTEST_SUFFIX = 4


def new_id(sighting: Sighting, *taken: Container[str]) -> str:
    """Return the id of a new device.

    The key, as in the thesis, for a device that its topic alone tells of; else its name in plain letters. Where that is
    taken, the gateway or a few letters of its identity follow.

    Args:
        sighting: How it was announced.
        taken: Ids that were given to other devices.
    """
    if not sighting.identifiers and (sighting.speaks_plainly or not sighting.parts):
        found = sighting.key
        while any(found in ids for ids in taken):
            found = f"{found}@{sighting.gateway}"
        return found
    slug = re.sub(r"[^a-z0-9]+", "_", fold(sighting.name))[:_LONGEST_SLUG].strip("_") or "device"
    if all(slug not in ids for ids in taken):
        return slug
    identity = _identity(sighting)
    for length in range(_SHORTEST_SUFFIX, len(identity) + 1):
        found = f"{slug}_{identity[-length:]}"
        if all(found not in ids for ids in taken):
            return found
    number = 2
    while any(f"{slug}_{identity}_{number}" in ids for ids in taken):
        number += 1
    return f"{slug}_{identity}_{number}"


def _identity(sighting: Sighting) -> str:
    hardware = next((one for one in sighting.identifiers if not one.startswith("id:")), "")
    if hardware:
        return hardware.partition(":")[2]
    named = "\0".join(sighting.identifiers or (sighting.gateway, sighting.key))
    return blake2b(named.encode(errors="surrogatepass"), digest_size=8).hexdigest()


@dataclass(frozen=True, slots=True)
class Tombstone:
    """A device that went.

    Attributes:
        id: The id it had, and gets again when it returns.
        keys: Its announcements.
        hardware: Its hardware addresses.
        retained_only: Whether it was forgotten, though its announcements may still be kept by the broker: these alone
            do not bring it back.
        at: When it went, in seconds since the Unix epoch.
    """

    id: str
    keys: tuple[SourceKey, ...]
    hardware: tuple[str, ...]
    retained_only: bool
    at: float


@final
class Tombstones:
    """Remembers devices that went, so that one that returns is recognised, and a ghost is not taken for one."""

    def __init__(self, at_most: int = MAX_TOMBSTONES) -> None:
        self._at_most = at_most
        self._stones: OrderedDict[str, Tombstone] = OrderedDict()
        self._by_key: dict[SourceKey, str] = {}
        self._by_hardware: dict[str, str] = {}

    def __len__(self) -> int:
        return len(self._stones)

    def __contains__(self, device_id: object) -> bool:
        return device_id in self._stones

    def __iter__(self) -> Iterator[Tombstone]:
        return iter(tuple(self._stones.values()))

    def put(self, stone: Tombstone) -> Tombstone | None:
        """Remember *stone*; return the one that is forgotten for it, if any."""
        self.take(stone.id)
        self._stones[stone.id] = stone
        self._by_key.update(dict.fromkeys(stone.keys, stone.id))
        self._by_hardware.update(dict.fromkeys(stone.hardware, stone.id))
        return self.take(next(iter(self._stones))) if len(self._stones) > self._at_most else None

    def find(self, key: SourceKey, identifiers: Iterable[str]) -> Tombstone | None:
        """Return the device that *key* announced, or that has one of the hardware addresses among *identifiers*."""
        found = self._by_key.get(key)
        if found is None:
            found = next((self._by_hardware[one] for one in identifiers if one in self._by_hardware), None)
        return None if found is None else self._stones[found]

    def get(self, device_id: str) -> Tombstone | None:
        """Return what is remembered of the device."""
        return self._stones.get(device_id)

    def take(self, device_id: str) -> Tombstone | None:
        """Forget the device and return what was remembered of it."""
        stone = self._stones.pop(device_id, None)
        if stone is not None:
            for key in stone.keys:
                if self._by_key.get(key) == device_id:
                    del self._by_key[key]
            for one in stone.hardware:
                if self._by_hardware.get(one) == device_id:
                    del self._by_hardware[one]
        return stone
