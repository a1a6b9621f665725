"""The registered announcements of a gateway, and their memory limits in gateway and directory. Pure.

Memory, measured: a device takes 15 kB with its one announcement and part, a further announcement of it 8 kB, a further
part of an announcement 3 kB. Length beyond that is an account of its own, the *excess*: a
house with many devices has many announcements, each as long as its parts need, and an attacker sends
long ones, of lists and of templates. Only the length beyond an honest one of as many parts counts.
"""

from collections import defaultdict
from collections.abc import Iterator
from typing import NamedTuple, TypeAlias

from homebot.conventions.description import DescribedPart, DeviceAnnounced
from homebot.conventions.text_codec import TextCodec
from homebot.devices.part import Part, size_of_texts, texts_of
from homebot.errors import WireError
from homebot.gateways.announced.announcement import AnnouncedPart, AvailabilityReader, StoredAnnouncement

__all__ = [
    "LISTED",
    "MAX_EXCESS",
    "MAX_EXCESS_EACH",
    "MAX_MEMORY",
    "DerivedAnnouncements",
    "DeviceRegistry",
    "Readers",
    "RegistryChange",
    "RegistryLimits",
    "excess_of",
]

MAX_EXCESS = 8 * 1024 * 1024
"""Bytes of all. In memory they are two to twelve times as much: the texts of lists two, templates twelve."""

MAX_EXCESS_EACH = 256 * 1024
"""Bytes of one: as long as a message may be that announces one device."""

_FREE = 3 * 1024
_FREE_PART = 1024
"""Bytes that are no excess: of one announcement, and of each of its parts. Of 1,495 configs that Zigbee2MQTT makes of
real devices, one part each, the longest has 2.3 kB, and devices with a hundred parts have about 1 kB for each."""

MAX_MEMORY = 512 * 1024 * 1024
"""Bytes of all: 30,000 devices with one announcement each, or all 4,478 models of Zigbee2MQTT by both of their ways."""

_DEVICE = 8 * 1024
_ANNOUNCEMENT = 5 * 1024
_PART = 3 * 1024

Readers: TypeAlias = tuple[tuple[str, AnnouncedPart | AvailabilityReader], ...]
"""Addresses, each with a part, or a source of availability, that is read there."""

LISTED = "the list of its bridge describes the device"
"""Why an announcement is removed."""


class DerivedAnnouncements:
    """The listed devices, and the announcements that their programs made of them before the list came.

    Zigbee2MQTT lists its devices with all that it knows, and announces each value of each device to Home Assistant as
    well: 34,000 announcements for 4,500 devices. A listed device needs none of them.

    All announcements here name their program, as the fact ``origin``.
    """

    def __init__(self) -> None:
        self._registered: defaultdict[tuple[bool, str, str], dict[str, DeviceAnnounced]] = defaultdict(dict)

    def is_derived(self, described: DeviceAnnounced) -> bool:
        """Return whether the program that made *described* lists the device itself."""
        return not described.native and any(_describes(one, described) for one in self._like(described, native=True))

    def of(self, listed: DeviceAnnounced) -> tuple[str, ...]:
        """Return the keys of the registered announcements that are derived from *listed*."""
        derived = [one.full_key for one in self._like(listed, native=False) if _describes(listed, one)]
        return tuple(dict.fromkeys(derived))

    def put(self, described: DeviceAnnounced) -> None:
        """Record a registered announcement."""
        for mark in _marks(described, native=described.native):
            self._registered[mark][described.full_key] = described

    def remove(self, described: DeviceAnnounced) -> None:
        """Record that an announcement is registered no more."""
        for mark in _marks(described, native=described.native):
            self._registered[mark].pop(described.full_key, None)
            if not self._registered[mark]:
                del self._registered[mark]

    def _like(self, described: DeviceAnnounced, *, native: bool) -> Iterator[DeviceAnnounced]:
        """Yield the lists, or all else, that are registered of the same device by the same program."""
        for mark in _marks(described, native=native):
            yield from self._registered.get(mark, {}).values()


def _marks(described: DeviceAnnounced, *, native: bool) -> list[tuple[bool, str, str]]:
    """Return the identifiers of the device, each with the program that announces it, and whether that lists it."""
    return [(native, described.facts["origin"], one) for one in described.identifiers]


def _describes(listed: DeviceAnnounced, announced: DeviceAnnounced) -> bool:
    """Return whether *announced* is at a topic of *listed*: a bridge that moved leaves its old list on the broker."""
    return any(one.part.is_below(listed.owns) for one in announced.parts)


class RegistryLimits(NamedTuple):
    """The limits on all announcements together.

    Attributes:
        readers: Parts that read one topic: each of its messages is work for all of them.
        excess: Bytes of all announcements beyond the length that their offers explain.
        excess_each: The same of one.
        memory: Bytes that all take, about.
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
    """The changes that a new description makes.

    Attributes:
        before: The announcement that it replaced, or None.
        refused: Addresses of states that cannot be read, with the reasons.
        readers: The readers of each address that had other readers before, so that they may have missed messages there.
    """

    stored: StoredAnnouncement
    before: StoredAnnouncement | None
    refused: tuple[WireError, ...] = ()
    readers: Readers = ()


class DeviceRegistry:
    """The devices of one gateway, or the announcements of them; a protocol adds the readers of each address.

    Attributes:
        by_key: The registered announcements, by key, in the order of arrival.
        derived: Those of them that name their program.
        excess: Bytes of all of them beyond the length that their offers explain.
    """

    def __init__(self, gateway: str, limits: RegistryLimits = _LIMITS) -> None:
        self.gateway = gateway
        self.by_key: dict[str, StoredAnnouncement] = {}
        self.derived = DerivedAnnouncements()
        self._limits = limits
        self._parts = 0
        self._devices: dict[tuple[str, ...], int] = {}  # by identifiers; an announcement without any is one
        self.excess = 0

    @property
    def memory(self) -> int:
        """Bytes that all that stand take, about."""
        return _ANNOUNCEMENT * len(self.by_key) + _PART * self._parts + _DEVICE * len(self._devices)

    def put(self, described: DeviceAnnounced, length: int = 0) -> RegistryChange:
        """Register *described*, replacing an earlier one of the same key.

        Args:
            length: Of the message that it alone was made of; 0 if that is unknown.

        Raises:
            WireError: It has more than 1,000 parts, is one device or part too many, too long, or there is no more
                memory for it. The announcement before it stays.
        """
        key = described.full_key
        before = self.by_key.get(key)
        self._check_room(described, before)
        excess = excess_of(described, length)
        if excess:
            self._check_excess(described.key, excess, 0 if before is None else before.excess)
        stored = StoredAnnouncement(self.gateway, key, described, excess)
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
        """Register *address*, of no device, for listeners to its raw messages; return key and name.

        Raises:
            WireError: As for :meth:`put`.
        """
        part = Part(id="", service_type="", reads=(address,))
        self.put(DeviceAnnounced(address, "", (), address, (DescribedPart(part, TextCodec(part)),), address))
        return address, address

    def remove(self, key: str) -> StoredAnnouncement | None:
        """Remove the announcement registered under *key*, and return it."""
        stored = self.by_key.pop(key, None)
        if stored is not None:
            self._forget(stored)
        return stored

    def _enter(
        self, stored: StoredAnnouncement, before: StoredAnnouncement | None
    ) -> tuple[tuple[WireError, ...], Readers]:
        """Register the readers of *stored*, replacing *before*. Return refused filters and readers that need a replay.

        It may raise, because a plug-in fails, and then nothing has changed.
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
        self._check_memory(described, before)

    def _check_memory(self, described: DeviceAnnounced, before: StoredAnnouncement | None) -> None:
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
        """Check that an excess of *size* may replace one of the size *before*; a shorter one always may."""
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
        """Count *stored*; with -1, count it no more."""
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
    """Return the bytes of *described* beyond the length that its number of parts explains.

    Args:
        length: Of the message that described it alone; 0 if the message described many, or its length is unknown: then
            only the lists, topics and facts of the description count.
    """
    texts = [*described.identifiers, *described.facts.values()]
    for one in described.parts:
        texts += texts_of(one.part)
    return max(0, max(length, size_of_texts(texts)) - _FREE - _FREE_PART * len(described.parts))
