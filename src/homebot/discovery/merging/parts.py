"""The parts of a device out of all announcements of it: each lamp once, with the ways to it. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import chain
from typing import TypeAlias

from homebot.devices import DevicePart, Route
from homebot.devices.device import EVERYTHING
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Part
from homebot.discovery.merging.capabilities import decided, settable_by
from homebot.discovery.merging.matching import Candidate, candidates, match
from homebot.discovery.merging.part_ids import NO_IDS, Named, PartIds, PartPlace, part_ids
from homebot.discovery.source_record import SourceRecord, preference
from homebot.discovery.topics.ownership import TopicOwnership

__all__ = ["MAX_PARTS", "MergedParts", "main_part", "merge_parts"]

MAX_PARTS = 1000
"""Parts of one device; further ones are left out."""


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


@dataclass(slots=True)
class _Told:
    """A part as one source tells of it: in one announcement, or in several that agree where it is told things."""

    part: Part
    claims: list[SourceRecord]


@dataclass(slots=True)
class _Merged:
    """A part in the making, the so-manieth; *ways* are those that nobody disputes, the preferred ones first.

    What the part is does not depend on who came first, so the ways are asked for that in the order of their sources.
    """

    part: Part
    number: int
    label: str
    places: list[tuple[int, PartPlace]] = field(default_factory=list)
    ways: list[_Way] = field(default_factory=list)


_Source: TypeAlias = tuple[bool, str, str]
"""Whether its convention is not the device's own, gateway, convention: native ones sort first."""

_Way: TypeAlias = tuple[PartPlace, _Source, Part]
"""Where a part is announced, by which source, and as what."""

_Telling: TypeAlias = tuple[SourceRecord, Part, _Told]


def merge_parts(claims: Sequence[SourceRecord], topics: TopicOwnership, known: PartIds = NO_IDS) -> MergedParts:
    """Return the parts that *claims* on one device tell of; those that are *known* keep their ids.

    Parts of different conventions or gateways are one as :mod:`homebot.discovery.merging.matching` says. In one
    convention they are one only when they have one id and the same topics. Two of one id that do not are in conflict:
    the older one counts.
    """
    if len(claims) == 1:
        return _parts_of_one(claims[0], topics, known)
    conflicts: list[str] = []
    tellings = _tellings(sorted(claims, key=preference), conflicts)
    groups = _groups(told for _, _, told in tellings)
    numbered: dict[int, _Merged] = {}
    places: dict[PartPlace, int] = {}
    left_out = 0
    for claim, part, told in tellings:
        group = groups[id(told)]
        found = numbered.get(group)
        if found is None:
            if len(numbered) >= MAX_PARTS:
                left_out += 1
                continue
            found = numbered[group] = _Merged(part, len(numbered), claim.label)
        place = (*claim.key, part.id)
        found.places.append((claim.number, place))
        if conflict := topics.conflict(claim, part):
            conflicts.append(conflict)
        else:
            found.ways.append((place, _source(claim), part))
        places[place] = found.number
    if left_out:
        conflicts.append(_left_out(left_out))
    return MergedParts(_named(tuple(numbered.values()), known), tuple(conflicts), places)


def _parts_of_one(source: SourceRecord, topics: TopicOwnership, known: PartIds) -> MergedParts:
    """Return the parts of the usual device, of one announcement: nothing is to be matched."""
    conflicts: list[str] = []
    places: dict[PartPlace, int] = {}
    parts = source.sighting.parts[:MAX_PARTS]
    gateway, key = source.key
    convention = source.sighting.convention
    ids: Sequence[str] = [part.id for part in parts]
    if known or len(set(ids)) < len(ids):
        label = source.label
        ids = part_ids([Named(part, label, [(source.number, (gateway, key, part))]) for part in ids], known)
    merged: list[DevicePart] = []
    for number, part in enumerate(parts):
        places[gateway, key, part.id] = number
        routes: tuple[Route, ...] = ()
        if conflict := topics.conflict(source, part):
            conflicts.append(conflict)
        else:
            route = Route.of_checked(gateway=gateway, key=key, part=part.id, convention=convention, takes=EVERYTHING)
            routes = (route,)
        merged.append(DevicePart.of_checked(id=ids[number], part=part, routes=routes))
    if left_out := len(source.sighting.parts) - len(parts):
        conflicts.append(_left_out(left_out))
    return MergedParts(tuple(merged), tuple(conflicts), places)


def _left_out(count: int) -> str:
    return f"{count} further parts are left out, for a device has {MAX_PARTS:,} at most"


def main_part(parts: Sequence[DevicePart]) -> DevicePart | None:
    """Return the part that a device is there for: no setting or diagnosis, and rather a lamp than its thermometer."""
    if len(parts) == 1:
        return parts[0]
    return min(
        parts, key=lambda one: (bool(one.part.category), _RANK.get(one.part.service_type, len(_RANK))), default=None
    )


_RANK = {name: number for number, name in enumerate(DEVICE_TYPES)}


def _tellings(claims: Sequence[SourceRecord], conflicts: list[str]) -> list[_Telling]:
    """Each part of each claim, and which part of its source that is; those that are another's are in *conflicts*."""
    found: list[_Telling] = []
    namesakes: dict[tuple[_Source, str, str], list[_Told]] = {}
    for claim in claims:
        source = _source(claim)
        for part in claim.sighting.parts:
            others = namesakes.setdefault((source, part.service_type, part.id), [])
            older = [one for one in others if one.claims[0] is not claim]
            told = next((one for one in older if _same_topics(part, one.part)), None)
            if told is None and older and part.id:
                conflicts.append(f"{claim.label} announces {part.id!r}, which is {older[0].claims[0].label}'s")
                continue
            if told is None:
                told = _Told(part, [])
                others.append(told)
            told.claims.append(claim)
            found.append((claim, part, told))
    return found


def _groups(told: Iterable[_Told]) -> dict[int, int]:
    """Return which part of the device each is, by a number of no meaning."""
    sources: dict[_Source, list[_Told]] = {}
    seen: set[int] = set()
    for one in told:
        if id(one) not in seen:
            seen.add(id(one))
            sources.setdefault(_source(one.claims[0]), []).append(one)
    groups: list[list[Candidate]] = []
    found: dict[int, int] = {}
    for source in sorted(sources):
        parts = sources[source]
        if len(sources) == 1:
            return {id(one): number for number, one in enumerate(parts)}
        identifiers = chain.from_iterable(claim.sighting.identifiers for one in parts for claim in one.claims)
        described = candidates([one.part for one in parts], dict.fromkeys(identifiers))
        same = match(groups, described)
        for number, (one, candidate) in enumerate(zip(parts, described, strict=True)):
            group = same.get(number, len(groups))
            if group == len(groups):
                groups.append([])
            groups[group].append(candidate)
            found[id(one)] = group
    return found


def _named(merged: Sequence[_Merged], known: PartIds) -> tuple[DevicePart, ...]:
    ids: Sequence[str] = [one.part.id for one in merged]
    if known or len(set(ids)) < len(ids):
        ids = part_ids([Named(one.part.id, one.label, one.places) for one in merged], known)
    return tuple(_device_part(part_id, one) for part_id, one in zip(ids, merged, strict=True))


def _device_part(part_id: str, one: _Merged) -> DevicePart:
    part = decided([way[2] for way in sorted(one.ways, key=lambda way: way[1])]) if len(one.ways) > 1 else one.part
    routes = tuple(
        Route.of_checked(gateway=gateway, key=key, part=name, convention=convention, takes=settable_by(described, part))
        for (gateway, key, name), (_, _, convention), described in one.ways
    )
    return DevicePart.of_checked(id=part_id, part=part, routes=routes)


def _source(claim: SourceRecord) -> _Source:
    sighting = claim.sighting
    return not sighting.native, sighting.gateway, sighting.convention


def _same_topics(part: Part, other: Part) -> bool:
    if part.writes or other.writes:
        return set(part.writes) == set(other.writes)
    return part.reads == other.reads
