"""One announcement of a device, and its reports; a device has one or more."""

import math
from collections.abc import Container, Mapping
from dataclasses import dataclass, field
from operator import itemgetter
from types import MappingProxyType
from typing import Any, TypeAlias, TypeVar

from homebot.devices import Fact, Sighting
from homebot.discovery.search.columns import StoredValue
from homebot.messages import Time

KeyT = TypeVar("KeyT")
ValueT = TypeVar("ValueT")

SourceKey: TypeAlias = tuple[str, str]
"""Gateway, and its key of the announcement."""

_NOTHING: Mapping[Any, Any] = MappingProxyType({})
"""A shared empty mapping: most announcements need none of their own, and an empty dict takes 64 bytes."""


@dataclass(slots=True)
class Reach:
    """A report of reachability.

    Attributes:
        value: Whether the device or part can be reached; None for unknown.
        heard_at: ``since`` on the monotonic clock.
        live: Whether it was reported live, rather than in a retained message.
        address: Where it was reported: a topic of the device, or of its bridge.
    """

    value: bool | None
    since: Time
    heard_at: float
    live: bool
    address: str


@dataclass(frozen=True, slots=True)
class LostLink:
    """The lost link of a gateway, which cannot reach its devices without it."""

    since: Time
    why: str


@dataclass(slots=True, eq=False)
class SourceRecord:
    """The knowledge of one gateway under one key.

    Attributes:
        sighting: The newest sighting; the description counts.
        number: The order of arrival.
        seen_at: When the device last reported through it, or it was announced.
        heard_at: The same on the monotonic clock; minus infinity if that was before the start.
        confirmed: Whether the device itself has been heard through it since the start.
        facts: The facts, with their values and the times of their first announcement.
        reach: Reported reachability by part; the whole device is ``""``. See :meth:`set_reach`.
        unreadable: By part, the fact that it sent what could not be read.
        lost: The lost link of its gateway; None while there is one.
        is_online: Whether it has reported itself online, so that its last will would report its end.
        absences: The newest input, on the monotonic clock, when each part was last unreachable; ``""`` for the device,
            which also is when its gateway has no link.
        is_claimed: Whether its endpoint is not trusted with commands; see :mod:`homebot.discovery.merging.trust`.
    """

    sighting: Sighting
    number: int
    first_seen: Time
    seen_at: Time
    confirmed: bool
    heard_at: float = -math.inf
    key: SourceKey = field(init=False)
    facts: Mapping[str, tuple[str, Time]] = field(init=False)
    values: dict[tuple[str, str], StoredValue] = field(default_factory=dict)
    events: Mapping[tuple[str, str], StoredValue] = field(init=False)
    reach: Mapping[str, Reach] = field(init=False)
    unreadable: Mapping[str, Fact] = field(init=False)
    lost: LostLink | None = None
    is_online: bool = False
    is_claimed: bool = False
    absences: Mapping[str, float] = field(init=False)

    def __post_init__(self) -> None:
        self.key = (self.sighting.gateway, self.sighting.key)
        self.facts = self.events = self.reach = self.unreadable = self.absences = _NOTHING

    def set_reach(self, reach: Mapping[str, Reach]) -> None:
        """Store *reach* as the reported reachability."""
        self.reach = reach or _NOTHING
        self.is_online = any(reach_of_part.value and reach_of_part.live for reach_of_part in reach.values())

    @property
    def is_lost(self) -> bool:
        """True if its gateway has lost its link, unless it reports a working link of its own to this device."""
        if self.lost is None:
            return False
        whole = None if self.sighting.convention else self.reach.get("")  # otherwise it comes from a last will
        return whole is None or not whole.value

    def reach_of(self, part: str) -> Reach | None:
        """Return the last reachability of *part*, or of the whole device; None if there was none."""
        return self.reach.get(part) or self.reach.get("")

    @property
    def lasts(self) -> float:
        """Seconds of silence that its gateway considers normal."""
        seen, expires = self.sighting.seen_at, self.sighting.expires_at
        return max(0.0, expires.sec - seen.sec + (expires.nanosec - seen.nanosec) / 1e9)

    @property
    def label(self) -> str:
        """A name for people, for example ``homeassistant:light/0x17_light``."""
        sighting = self.sighting
        prefix = f"{sighting.convention}:"
        if not sighting.convention or sighting.key.startswith(prefix):
            return sighting.key
        return prefix + sighting.key


def preference(source: SourceRecord) -> tuple[bool, bool, bool, int]:
    """Return the sort key for sources of one device: claimed ones last, native conventions and older ones first.

    An announcement that is neither native nor of any convention comes from a hub that passes its devices on, and is
    preferred least.
    """
    sighting = source.sighting
    return source.is_claimed, not sighting.native, not (sighting.native or sighting.convention), source.number


_DESCRIPTION = itemgetter(
    "name",
    "service_type",
    "address",
    "command_address",
    "identifiers",
    "authenticated",
    "area",
    "owns",
    "convention",
    "native",
    "whole_device",
    "metadata",
    "parts",
)


def is_described_anew(before: Sighting, now: Sighting) -> bool:
    """Return whether *now* differs from *before* in more than time and reason."""
    return bool(_DESCRIPTION(vars(before)) != _DESCRIPTION(vars(now)))


def record_description(source: SourceRecord, before: Sighting) -> None:
    """Record when *source* first announced each fact; drop the values of capabilities that it no longer has.

    A part that left an address on which it reported has no values until it reports on its current ones.
    """
    now = source.sighting
    known, described = _facts_of(before), _facts_of(now)
    changed = {name: (value, now.seen_at) for name, value in described.items() if known.get(name) != value}
    source.facts = {**_only(source.facts, described), **changed} or _NOTHING
    places = {(part.id, capability.name) for part in now.parts for capability in part.capabilities}
    reads = {part.id: part.reads for part in now.parts}
    left = {part.id for part in before.parts if not set(part.reads).issubset(reads.get(part.id, ()))}
    source.values = _only(source.values, {place for place in places if place[0] not in left} if left else places)
    source.events = _only(source.events, places) or _NOTHING
    source.unreadable = _only(source.unreadable, reads) or _NOTHING
    source.set_reach(_only(source.reach, {"", *(part.id for part in now.parts)}))


def _facts_of(sighting: Sighting) -> dict[str, str]:
    return {"name": sighting.name, "area": sighting.area, **{item.key: item.value for item in sighting.metadata}}


def _only(value_ts: Mapping[KeyT, ValueT], keys: Container[KeyT]) -> dict[KeyT, ValueT]:
    return {key: value for key, value in value_ts.items() if key in keys}
