"""The parts of a device out of all announcements of it: each lamp once, with the ways to it. Pure."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from operator import attrgetter
from typing import TypeAlias

from homebot.devices import DevicePart, Route
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Part
from homebot.devices.query.folding import fold
from homebot.discovery.abilities import taken_by, united
from homebot.discovery.claim import Claim, preference
from homebot.discovery.part_ids import NO_IDS, Named, PartIds, PartPlace, part_ids

__all__ = ["MAX_COMPARED", "MAX_PARTS", "Disputed", "MergedParts", "main_part", "merge_parts"]

MAX_PARTS = 1000
"""Parts of one device; further ones are left out."""

MAX_COMPARED = 10_000
"""How often two parts of one type are held against each other; further ones stay parts of their own."""

Disputed: TypeAlias = Callable[[Claim, Part], str]
"""Says in words who else has what a part of a claim would use; empty for nobody."""


@dataclass(frozen=True, slots=True)
class MergedParts:
    """The parts of a device.

    Attributes:
        parts: The parts, in the order of the preferred announcements.
        conflicts: What was left out, and why, in words.
        places: Which part of the device each part of a claim is, by gateway, key and part.
    """

    parts: tuple[DevicePart, ...]
    conflicts: tuple[str, ...]
    places: dict[PartPlace, int]

    def ids(self) -> dict[PartPlace, str]:
        """Return which id the part has that each part of a claim is."""
        return {place: self.parts[number].id for place, number in self.places.items()}


_Source: TypeAlias = tuple[str, str]
"""Gateway and convention."""


@dataclass(slots=True)
class _Merged:
    """A part in the making, the so-manieth; *ways* are those that nobody disputes."""

    part: Part
    number: int
    claims: list[Claim] = field(default_factory=list)
    places: list[tuple[int, PartPlace]] = field(default_factory=list)
    ways: list[tuple[PartPlace, str, Part]] = field(default_factory=list)


@dataclass(slots=True)
class _SameType:
    """The parts of one type, by whose they are first: a thousand of one source must not be held against each other."""

    by_source: dict[_Source, list[_Merged]] = field(default_factory=dict)
    by_id: dict[tuple[_Source, str], list[_Merged]] = field(default_factory=dict)
    compared: int = 0

    def add(self, claim: Claim, one: _Merged) -> None:
        source = _source(claim)
        self.by_source.setdefault(source, []).append(one)
        self.by_id.setdefault((source, one.part.id), []).append(one)

    def namesakes(self, claim: Claim, part: Part) -> Iterator[_Merged]:
        """Those that another announcement of the same source calls the same."""
        return (one for one in self.by_id.get((_source(claim), part.id), ()) if one.claims[0] is not claim)

    def strangers(self, claim: Claim) -> list[_Merged]:
        """Those that no announcement of the same source tells of, in their order, to be held against one of its."""
        mine = _source(claim)
        found = [one for source, some in self.by_source.items() if source != mine for one in some]
        self.compared += len(found)
        if self.compared > MAX_COMPARED:
            return []
        found.sort(key=attrgetter("number"))
        return [one for one in found if all(_source(other) != mine for other in one.claims)]


def merge_parts(claims: Sequence[Claim], disputed: Disputed, known: PartIds = NO_IDS) -> MergedParts:
    """Return the parts that *claims* on one device tell of; those that are *known* keep their ids.

    Two parts are one when they are of one type, come from different conventions or gateways, and have one name, or
    related ids, or are the only ones of their type or with their capabilities. In one convention they are one only when
    they have one id and the same topics. Two of one id that do not are in conflict: the older one counts.
    """
    merged: list[_Merged] = []
    by_type: dict[str, _SameType] = {}
    places: dict[PartPlace, int] = {}
    conflicts: list[str] = []
    ordered = sorted(claims, key=preference) if len(claims) > 1 else claims
    alone: frozenset[_Place] = _only_ones(ordered) if len(claims) > 1 else frozenset()
    left_out = 0
    for claim in ordered:
        gateway, key = claim.key
        for part in claim.sighting.parts:
            same_type = by_type.setdefault(part.service_type, _SameType())
            rival = _rival(claim, part, same_type) if len(claims) > 1 else None
            if rival is not None:
                conflicts.append(f"{claim.label} announces {part.id!r}, which is {rival.claims[0].label}'s")
                continue
            found = _twin(claim, part, same_type, alone) if len(claims) > 1 else None
            if found is not None and part.writes and _is_rather_another(claim, part, found, merged):
                found = None
            if found is None:
                if len(merged) >= MAX_PARTS:
                    left_out += 1
                    continue
                found = _Merged(part, len(merged))
                same_type.add(claim, found)
                merged.append(found)
            place = (gateway, key, part.id)
            found.claims.append(claim)
            found.places.append((claim.number, place))
            if dispute := disputed(claim, part):
                conflicts.append(dispute)
            else:
                found.ways.append((place, claim.sighting.convention, part))
            places[place] = found.number
    if left_out:
        conflicts.append(f"{left_out} further parts are left out, for a device has {MAX_PARTS:,} at most")
    return MergedParts(_named(merged, known), tuple(conflicts), places)


def main_part(parts: Iterable[DevicePart]) -> DevicePart | None:
    """Return the part that a device is there for: no setting or diagnosis, and rather a lamp than its thermometer."""
    return min(
        parts, key=lambda one: (bool(one.part.category), _RANK.get(one.part.service_type, len(_RANK))), default=None
    )


_RANK = {name: number for number, name in enumerate(DEVICE_TYPES)}


def _named(merged: Sequence[_Merged], known: PartIds) -> tuple[DevicePart, ...]:
    ids: Sequence[str] = [one.part.id for one in merged]
    if known or len(set(ids)) < len(ids):
        ids = part_ids([Named(one.part.id, one.claims[0].label, one.places) for one in merged], known)
    return tuple(_device_part(part_id, one) for part_id, one in zip(ids, merged, strict=True))


def _device_part(part_id: str, one: _Merged) -> DevicePart:
    part = united([found for _, _, found in one.ways]) if len(one.ways) > 1 else one.part
    routes = tuple(
        Route.of_checked(gateway=gateway, key=key, part=name, convention=convention, takes=taken_by(described, part))
        for (gateway, key, name), convention, described in one.ways
    )
    return DevicePart.of_checked(id=part_id, part=part, routes=routes)


def _only_ones(claims: Sequence[Claim]) -> frozenset[_Place]:
    """The parts that have no second of their kind in one gateway and convention, by type, and by capabilities too."""
    counts: Counter[_Place] = Counter()
    for claim in claims:
        for part in claim.sighting.parts:
            counts.update(_places(claim, part))
    return frozenset(place for place, count in counts.items() if count == 1)


def _places(claim: Claim, part: Part) -> tuple[_Place, ...]:
    sighting = claim.sighting
    exact = (sighting.gateway, sighting.convention, part.service_type, _abilities(part))
    return (exact,) if part.category else (exact, (*exact[:3], _ANYTHING))


def _abilities(part: Part) -> frozenset[str]:
    return frozenset(one.name for one in part.capabilities)


_Place: TypeAlias = tuple[str, str, str, frozenset[str]]
_ANYTHING = frozenset({"*"})


def _rival(claim: Claim, part: Part, others: _SameType) -> _Merged | None:
    """The part that another announcement in the same convention calls the same, though it is elsewhere."""
    first = next(others.namesakes(claim, part), None) if part.id else None
    return None if first is None or _same_topics(part, first.part) else first


def _twin(claim: Claim, part: Part, others: _SameType, alone: frozenset[_Place]) -> _Merged | None:
    """The part that is most likely the same, if one is."""
    same = next((one for one in others.namesakes(claim, part) if _same_topics(part, one.part)), None)
    if same is not None:
        return same
    best, likelihood = None, 0
    for other in others.strangers(claim):
        found = _likelihood(claim, part, other, alone)
        if found > likelihood:
            best, likelihood = other, found
    return best


def _likelihood(claim: Claim, part: Part, other: _Merged, alone: frozenset[_Place]) -> int:
    """How sure it is that two parts of one type in different conventions are one; 0 for not at all."""
    is_alike = part.category == other.part.category
    if not is_alike and (part.writes or other.part.writes):
        return 0
    if part.name and is_alike and fold(part.name) == fold(other.part.name):
        return _BY_NAME
    is_able = _abilities(part) == _abilities(other.part)
    shares_topic = not set(part.reads).isdisjoint(other.part.reads)
    if is_able and shares_topic and (shared := _shared_id(part.id, other.part.id)):
        return _BY_ID + shared
    mine, others = _places(claim, part), _places(other.claims[0], other.part)
    if len(mine) == len(others) and mine[-1] in alone and others[-1] in alone and is_alike:
        return _BY_TYPE
    if is_able and shares_topic and mine[0] in alone and others[0] in alone:
        return _BY_ABILITY
    writes = set(part.writes)
    if writes and part.name == other.part.name and not writes.isdisjoint(other.part.writes):
        return _BY_TOPIC
    return 0


def _is_rather_another(claim: Claim, part: Part, twin: _Merged, merged: Iterable[_Merged]) -> bool:
    """Whether the id of *part* says that it is no *twin* but a part of another type.

    A switch ``0x17_switch_child_lock`` is what the other convention calls the setting ``child_lock``, and to tell it
    something must not reach the load that is called ``switch`` there.
    """
    shared = _shared_id(part.id, twin.part.id)
    if not shared or set(part.writes) & set(twin.part.writes):
        return False
    return any(
        one.part.service_type != part.service_type
        and _shared_id(part.id, one.part.id) > shared
        and _source(claim) != _source(one.claims[0])
        for one in merged
    )


_BY_TOPIC, _BY_ABILITY, _BY_TYPE, _BY_ID, _BY_NAME = 1, 2, 3, 10, 1_000_000


def _shared_id(one: str, other: str) -> int:
    """How many letters two ids share, where one is in the other as ``state_l1`` is in ``0x17_state_l1_light``."""
    short, long = sorted((fold(one), fold(other)), key=len)
    return len(short) if short and f" {short} " in f" {long} " else 0


def _source(claim: Claim) -> _Source:
    return claim.sighting.gateway, claim.sighting.convention


def _same_topics(part: Part, other: Part) -> bool:
    if part.writes or other.writes:
        return set(part.writes) == set(other.writes)
    return part.reads == other.reads
