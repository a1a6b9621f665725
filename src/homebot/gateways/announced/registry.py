"""The registered announcements of a gateway, and their memory limits in gateway and directory. Pure.

Measured memory: a device with one announcement of one part takes 15 kB, each further announcement 8 kB, each further
part 3 kB. Length beyond that has a limit of its own, the *excess*: a large house sends many announcements, each as long
as its parts require, while an attacker sends long lists and templates.
"""

from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.conventions.text_codec import TextCodec
from homebot.devices.part import Part, size_of_texts, texts_of
from homebot.errors import WireError
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement

MAX_EXCESS = 8 * 1024 * 1024
"""Bytes in total. In memory, texts of lists take twice as much and templates twelve times."""

MAX_EXCESS_EACH = 256 * 1024
"""Bytes per announcement: the longest message that may announce one device."""

_FREE = 3 * 1024
_FREE_PART = 1024
"""Bytes that are not excess, per announcement and per part. Of 1,495 one-part configs that Zigbee2MQTT makes of real
devices the longest has 2.3 kB; devices with a hundred parts need about 1 kB for each."""

MAX_MEMORY = 512 * 1024 * 1024
"""Bytes in total: 30,000 devices with one announcement each, or all 4,478 models of Zigbee2MQTT announced both ways."""

_DEVICE = 8 * 1024
_ANNOUNCEMENT = 5 * 1024
_PART = 3 * 1024

Readers: TypeAlias = tuple[tuple[str, AnnouncedPart | AvailabilityReader], ...]
"""Addresses, each with the part or availability source that is read there."""

LISTED = "the list of its bridge describes the device"
"""The reason for removing an announcement."""


_ByMark: TypeAlias = defaultdict[tuple[str, str], dict[str, DeviceAnnounced]]
"""Announcements by mark, see :func:`_marks`, and key."""


class DerivedAnnouncements:
    """Devices that a bridge lists, and announcements of the same devices that the list makes redundant.

    Zigbee2MQTT lists its devices with everything it knows, and also announces each value of each device to Home
    Assistant: 34,000 announcements for 4,500 devices. All announcements here name their program as the fact ``origin``.
    """

    def __init__(self) -> None:
        self._listed: _ByMark = defaultdict(dict)
        self._others: _ByMark = defaultdict(dict)

    def is_derived(self, described: DeviceAnnounced) -> bool:
        """Return whether the program that announced *described* also lists the device."""
        if described.native or not self._listed:
            return False
        return any(_describes(entry, described) for entry in _like(described, self._listed))

    def of(self, listed: DeviceAnnounced) -> tuple[str, ...]:
        """Return the keys of the registered announcements that are derived from *listed*."""
        derived = [
            derived_device.full_key
            for derived_device in _like(listed, self._others)
            if _describes(listed, derived_device)
        ]
        return tuple(dict.fromkeys(derived))

    def put(self, described: DeviceAnnounced) -> None:
        """Record a registered announcement."""
        registered, key = self._of_its_kind(described), described.full_key
        for mark in _marks(described):
            registered[mark][key] = described

    def remove(self, described: DeviceAnnounced) -> None:
        """Record that an announcement is no longer registered."""
        registered = self._of_its_kind(described)
        for mark in _marks(described):
            registered[mark].pop(described.full_key, None)
            if not registered[mark]:
                del registered[mark]

    def _of_its_kind(self, described: DeviceAnnounced) -> _ByMark:
        return self._listed if described.native else self._others


def _like(described: DeviceAnnounced, registered: _ByMark) -> Iterator[DeviceAnnounced]:
    """Yield the *registered* announcements of the same device by the same program."""
    for mark in _marks(described):
        yield from registered.get(mark, {}).values()


def _marks(described: DeviceAnnounced) -> list[tuple[str, str]]:
    """Return the marks under which an announcement is found: its program, with each identifier of the device."""
    origin = described.facts["origin"]
    return [(origin, identifier) for identifier in described.identifiers]


def _describes(listed: DeviceAnnounced, announced: DeviceAnnounced) -> bool:
    """Return whether *announced* is below *listed*'s topics: a bridge that moved leaves its old list on the broker."""
    return any(part.part.is_below(listed.owns) for part in announced.parts)


class RegistryLimits(NamedTuple):
    """The limits on all announcements of a gateway.

    Attributes:
        readers: Parts that may read one topic, because each of its messages is work for all of them.
        excess: Bytes of all announcements beyond the length that their parts justify.
        excess_each: The same per announcement.
        memory: Estimated bytes of all announcements.
    """

    announcements: int = 50_000
    parts: int = 200_000
    parts_each: int = 1000
    readers: int = 5000
    excess: int = MAX_EXCESS
    excess_each: int = MAX_EXCESS_EACH
    memory: int = MAX_MEMORY


_LIMITS = RegistryLimits()


class RegistryChange(NamedTuple):
    """The result of registering a description.

    Attributes:
        before: The announcement that it replaced, or None.
        refused: The reasons for addresses that cannot be read.
        readers: Readers that may have missed messages, because their address had other readers before.
    """

    stored: StoredAnnouncement
    before: StoredAnnouncement | None
    refused: tuple[WireError, ...] = ()
    readers: Readers = ()


class DeviceRegistry:
    """The announcements of one gateway; a protocol's subclass adds the readers of each address.

    Attributes:
        by_key: The registered announcements by key, oldest first.
        derived: The announcements that name their program.
        excess: Bytes of all announcements beyond the length that their parts justify.
    """

    def __init__(self, gateway: str, limits: RegistryLimits = _LIMITS) -> None:
        self.gateway = gateway
        self.by_key: dict[str, StoredAnnouncement] = {}
        self.derived = DerivedAnnouncements()
        self._limits = limits
        self._parts = self._announced = 0
        self._devices: dict[tuple[str, ...], int] = {}  # announcements by identifiers; one without any is a device
        self.excess = 0

    @property
    def memory(self) -> int:
        """Estimated bytes of all announcements."""
        return _ANNOUNCEMENT * len(self.by_key) + _PART * self._parts + _DEVICE * len(self._devices)

    def put(self, described: DeviceAnnounced, length: int = 0, *, is_retained: bool = False) -> RegistryChange:
        """Register *described*, replacing an earlier one of the same key.

        Args:
            length: Bytes of its message; 0 if unknown, or if the message describes several devices.
            is_retained: Whether it was announced before, nobody knows when.

        Raises:
            WireError: It exceeds a limit: of parts, announcements, length or memory. The earlier announcement stays.
        """
        key = described.full_key
        before = self.by_key.get(key)
        self._check_room(described, before)
        excess = excess_of(described, length)
        if excess:
            self._check_excess(described.key, excess, 0 if before is None else before.excess)
        self._announced += 1
        stored = StoredAnnouncement(self.gateway, key, described, excess, 0 if is_retained else self._announced)
        if before is not None and stored.has_topics_of(before):
            stored.since = before.since
        refused, readers = self._enter(stored, before)
        if before is not None:
            stored.copy_state(before)
            self._forget(before)
        self.by_key[key] = stored
        self._count(stored, 1)
        if "origin" in described.facts:
            self.derived.put(described)
        return RegistryChange(stored, before, refused, readers)

    def put_address(self, address: str) -> tuple[str, str]:
        """Register *address* without a device, for listeners to its raw messages; return key and name.

        Raises:
            WireError: As for :meth:`put`.
        """
        part = Part(id="", service_type="", reads=(address,))
        self.put(DeviceAnnounced(address, "", (), address, (DescribedPart(part, TextCodec(part)),), address))
        return address, address

    def remove(self, key: str) -> StoredAnnouncement | None:
        """Remove the announcement under *key*, and return it."""
        stored = self.by_key.pop(key, None)
        if stored is not None:
            self._forget(stored)
        return stored

    def _enter(
        self, stored: StoredAnnouncement, before: StoredAnnouncement | None
    ) -> tuple[tuple[WireError, ...], Readers]:
        """Register the readers of *stored*, replacing *before*; return refused filters and readers that need a replay.

        If it raises, as when a plug-in fails, nothing has changed.
        """
        del stored, before
        return (), ()

    def _leave(self, stored: StoredAnnouncement) -> None:
        """Remove the readers of *stored*."""

    def _forget(self, stored: StoredAnnouncement) -> None:
        self._leave(stored)
        self._count(stored, -1)
        if "origin" in stored.described.facts:
            self.derived.remove(stored.described)

    def _check_room(self, described: DeviceAnnounced, before: StoredAnnouncement | None) -> None:
        limits = self._limits
        if before is not None and before.described.convention != described.convention:
            raise WireError(f"{described.full_key!r} is already the key of a device of {before.described.convention}")
        count = len(described.parts)
        if count > limits.parts_each:
            raise WireError(f"{described.key!r} has {count} parts; {limits.parts_each:,} is the limit")
        if before is None and len(self.by_key) >= limits.announcements:
            raise WireError(f"{described.key!r} exceeds the limit of {limits.announcements:,} announcements")
        if self._parts + count - (0 if before is None else len(before.described.parts)) > limits.parts:
            raise WireError(f"{described.key!r} exceeds the limit of {limits.parts:,} parts in all")
        more = _PART * (len(described.parts) - (0 if before is None else len(before.described.parts)))
        if before is None:
            more += _ANNOUNCEMENT
        if (described.identifiers or (described.convention, described.key)) not in self._devices:
            more += _DEVICE
        if more > 0 and self.memory + more > self._limits.memory:
            raise WireError(
                f"{described.key!r} does not fit: announcements take {self.memory:,} bytes already, and "
                f"{self._limits.memory:,} is the limit; withdraw some, or raise max_memory of the gateway"
            )

    def _check_excess(self, name: str, size: int, before: int) -> None:
        """Check that an excess of *size* bytes may replace one of *before*; a smaller one always may."""
        if size <= before:
            return
        if size > self._limits.excess_each:
            raise WireError(
                f"{name!r} is {size:,} bytes too long for its parts; at most {self._limits.excess_each:,} are allowed"
            )
        if self.excess + size - before > self._limits.excess:
            raise WireError(
                f"{name!r} is {size:,} bytes too long for its parts, and there are long announcements of "
                f"{self.excess:,} bytes already; withdraw some of them or shorten it"
            )

    def _count(self, stored: StoredAnnouncement, sign: int) -> None:
        """Add *stored* to the totals; subtract it if *sign* is -1."""
        described = stored.described
        self._parts += sign * len(described.parts)
        self.excess += sign * stored.excess
        device = described.identifiers or (described.convention, described.key)
        count = self._devices.get(device, 0) + sign
        if count:
            self._devices[device] = count
        else:
            del self._devices[device]


def excess_of(described: DeviceAnnounced, length: int) -> int:
    """Return the bytes of *described* beyond the length that its number of parts justifies.

    Args:
        length: As for :meth:`DeviceRegistry.put`; with 0, only lists, topics and facts of the description count.
    """
    texts = [*described.identifiers, *described.facts.values()]
    for part in described.parts:
        texts += texts_of(part.part)
    return max(0, max(length, size_of_texts(texts)) - _FREE - _FREE_PART * len(described.parts))
