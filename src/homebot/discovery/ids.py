"""The ids of devices, and the memory of removed devices. Pure."""

import re
from collections import OrderedDict
from collections.abc import Container, Iterable, Iterator
from hashlib import blake2b
from itertools import accumulate, count, repeat
from typing import NamedTuple, final

from homebot.devices import Sighting
from homebot.discovery.source_record import SourceKey
from homebot.support.folding import fold

MAX_TOMBSTONES = 10_000
"""Most removed devices remembered; the oldest is forgotten."""

_NO_LETTERS = re.compile(r"[^a-z0-9]+")
_FOR_PROGRAMS = re.compile(r"[a-z]+(?:_[a-z0-9]+)+")
"""A name as in ``kitchen_lamp``, which people say in words."""
_MAX_SLUG = 60
_SHORTEST_SUFFIX = 4


def new_id(sighting: Sighting, known: Container[str], gone: Container[str]) -> str:
    """Return the id of a new device.

    It is the key, as in the thesis, for a device known only by its topic; else its name in plain letters. If that is
    taken, the gateway or a few letters of its identity are appended.
    """
    if not sighting.identifiers and (sighting.is_plain_text or not sighting.parts):
        proposals: Iterator[str] = accumulate(repeat(f"@{sighting.gateway}"), initial=sighting.key)
    else:
        slug = id_of_name(sighting.name or name_without(sighting))
        if slug not in known and slug not in gone:
            return slug
        proposals = _longer_ids(slug, _identity(sighting))
    return next(device_id for device_id in proposals if device_id not in known and device_id not in gone)


def _longer_ids(slug: str, identity: str) -> Iterator[str]:
    for length in range(_SHORTEST_SUFFIX, len(identity) + 1):
        yield f"{slug}_{identity[-length:]}"
    for number in count(2):
        yield f"{slug}_{identity}_{number}"


def name_without(sighting: Sighting) -> str:
    """Return a name for an unnamed device: that of a part, or the end of the key, as people say it."""
    key = sighting.key.rpartition("/")[2]
    spoken = key.capitalize().replace("_", " ") if _FOR_PROGRAMS.fullmatch(key) else key
    return next((part.name for part in sighting.parts if part.name), "") or spoken


def id_of_name(name: str) -> str:
    """Return the id for a device of that name, if it is not taken."""
    return _NO_LETTERS.sub("_", fold(name))[:_MAX_SLUG].strip("_") or "device"


def _identity(sighting: Sighting) -> str:
    hardware = next((identifier for identifier in sighting.identifiers if not identifier.startswith("id:")), "")
    if hardware:
        return hardware.partition(":")[2]
    named = "\0".join(sighting.identifiers or (sighting.gateway, sighting.key))
    return blake2b(named.encode(errors="surrogatepass"), digest_size=8).hexdigest()


class Tombstone(NamedTuple):
    """A removed device.

    Attributes:
        id: Its id, which it gets again when it returns.
        retained_only: Whether the owner had it forgotten, so that retained announcements do not bring it back.
        at: When it was removed, in seconds since the Unix epoch.
        trusted: The endpoints that got its commands; see :mod:`homebot.discovery.merging.trust`.
        first_seen: When it was first seen, in the same seconds; 0 if that is not known.
    """

    id: str
    keys: tuple[SourceKey, ...]
    hardware: tuple[str, ...]
    retained_only: bool
    at: float
    trusted: tuple[tuple[str, str], ...] = ()
    first_seen: float = 0.0


@final
class Tombstones:
    """The removed devices, to recognize one that returns and to ignore its leftovers.

    Attributes:
        by_id: The remembered devices, oldest first; most houses have none.
    """

    def __init__(self, at_most: int = MAX_TOMBSTONES) -> None:
        self._at_most = at_most
        self.by_id: OrderedDict[str, Tombstone] = OrderedDict()
        self._by_key: dict[SourceKey, str] = {}
        self._by_hardware: dict[str, str] = {}

    def __len__(self) -> int:
        return len(self.by_id)

    def __iter__(self) -> Iterator[Tombstone]:
        return iter(tuple(self.by_id.values()))

    def put(self, tombstone: Tombstone) -> Tombstone | None:
        """Remember *tombstone*; return the one forgotten in its place, if any."""
        self.pop(tombstone.id)
        self.by_id[tombstone.id] = tombstone
        self._by_key.update(dict.fromkeys(tombstone.keys, tombstone.id))
        self._by_hardware.update(dict.fromkeys(tombstone.hardware, tombstone.id))
        return self.pop(next(iter(self.by_id))) if len(self.by_id) > self._at_most else None

    def find(self, key: SourceKey, identifiers: Iterable[str]) -> Tombstone | None:
        """Return the device announced by *key*, or with one of the hardware addresses among *identifiers*."""
        if key in self._by_key:
            return self.by_id[self._by_key[key]]
        for identifier in identifiers:
            if identifier in self._by_hardware:
                return self.by_id[self._by_hardware[identifier]]
        return None

    def pop(self, device_id: str) -> Tombstone | None:
        """Forget the removed device, and return its record."""
        tombstone = self.by_id.pop(device_id, None)
        if tombstone is not None:
            for key in tombstone.keys:
                if self._by_key.get(key) == device_id:
                    del self._by_key[key]
            for identifier in tombstone.hardware:
                if self._by_hardware.get(identifier) == device_id:
                    del self._by_hardware[identifier]
        return tombstone
