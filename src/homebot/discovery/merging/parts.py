"""The parts of a device, merged from all its announcements, with ids, capabilities and routes. Pure."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import chain, starmap
from typing import Final, NamedTuple, TypeAlias

from homebot.devices import DevicePart, Route, Sighting
from homebot.devices.always_ask import asks_by_itself
from homebot.devices.device import EVERYTHING
from homebot.devices.device_types import DEVICE_TYPES
from homebot.devices.part import Capability, Part
from homebot.discovery.merging.matching import SETTING, Candidate, candidates, match
from homebot.discovery.merging.part_ids import NO_IDS, Named, PartIds, PartPlace, part_ids
from homebot.discovery.source_record import SourceRecord
from homebot.discovery.topics.ownership import TopicOwnership

# Looked up once, as `of_checked` says.
_part_of, _route_of = DevicePart.of_checked, Route.of_checked

MAX_PARTS = 1000
"""Most parts of one device; further ones are left out."""

CONFIRM = "confirm it with `homebot merge` and the name of the device, or undo it with `homebot split`"

_NONE_CLAIMED: Final[frozenset[int]] = frozenset()
_NONE_HIDDEN: Final[frozenset[PartPlace]] = frozenset()

_RANK = {name: number for number, name in enumerate(DEVICE_TYPES)}


Origin: TypeAlias = tuple[bool, bool, str, str]
"""Whether it is claimed, whether it is not native, gateway, convention. Claimed origins sort last, so that they do not
decide which parts of others are one."""

Way: TypeAlias = tuple[PartPlace, Origin, Part, Sighting]
"""The place of a part, the origin of its announcement, its description, and the announcement."""


def described_part(ways: Sequence[Way]) -> Part:
    """Return the part that *ways* describe, best first, with the capabilities of all; a setting if one of them says so.

    A source that states the category decides it, and for settings also the type, as Home Assistant calls a setting that
    is on or off a switch.
    """
    heard, others = _split_deciding(ways)
    whole = _merge_capabilities(heard + others)
    knows = next((part for part in heard if part.category), whole)
    is_setting = knows.service_type == SETTING
    service_type, advertised = (SETTING, knows.advertised) if is_setting else (whole.service_type, whole.advertised)
    if (knows.category, service_type) == (whole.category, whole.service_type):
        return whole
    changes = {"category": knows.category, "service_type": service_type, "advertised": advertised}
    return whole.model_copy(update=changes)


def settable_by(part: Part, whole: Part) -> tuple[str, ...]:
    """Return the capabilities of *whole* that can be set through the way described as *part*."""
    if part is whole:
        return EVERYTHING
    names = _settable(part)
    return EVERYTHING if names == _settable(whole) else tuple(names)


def _merge_capabilities(parts: Sequence[Part]) -> Part:
    """Return the first of *parts* with the capabilities of all: they describe the same part, best first."""
    best = parts[0]
    if len(parts) == 1 or all(part.capabilities == best.capabilities for part in parts):
        return best
    merged: dict[str, Capability] = {}
    for part in parts:
        for capability in part.capabilities:
            known = merged.get(capability.name)
            merged[capability.name] = capability if known is None else _join(known, capability)
    capabilities = tuple(merged.values())
    return best if capabilities == best.capabilities else best.model_copy(update={"capabilities": capabilities})


def _split_deciding(ways: Sequence[Way]) -> tuple[list[Part], list[Part]]:
    """Return the parts that decide on type and category, and the others.

    A setting decides if its source is authenticated, or owns the command topics of the loads that it may be, or has
    them too. Otherwise any program could announce it, and would make a harmless setting of a gate.
    """
    loads = [(gateway, part) for (gateway, *_), _, part, _ in ways if not part.category and _settable(part)]
    heard, others = list[Part](), list[Part]()
    for (gateway, *_), _, part, source in ways:
        known = frozenset((*part.writes, *source.owns))
        is_known = source.authenticated or all(at == gateway and _is_below(load.writes, known) for at, load in loads)
        (heard if is_known or not _is_setting(part) else others).append(part)
    return heard, others


def _is_below(topics: Sequence[str], known: Collection[str]) -> bool:
    """Return whether there are *topics*, and each is a *known* one or below one."""
    return bool(topics) and all(any(f"{topic}/".startswith(f"{above}/") for above in known) for topic in topics)


def _is_setting(part: Part) -> bool:
    return bool(part.category) or part.service_type == SETTING


def _settable(part: Part) -> dict[str, None]:
    return {capability.name: None for capability in part.capabilities if capability.settable}


def _all_options(best: Capability, other: Capability) -> tuple[str, ...]:
    both_have_some = best.options and other.options
    return tuple(dict.fromkeys(best.options + other.options)) if both_have_some else best.options


def _join(best: Capability, other: Capability) -> Capability:
    """Join two capabilities; if only one is settable, its range and options count, as they are those of commands."""
    if best == other:
        return best
    shown = other if other.settable and not best.settable else best
    options = _all_options(best, other) if best.settable == other.settable else shown.options
    readable, settable = best.readable or other.readable, best.settable or other.settable
    echoed = all(
        capability.echoed for capability in (best, other) if capability.readable
    )  # the other one is still readable
    code = best.code or other.code
    return shown.model_copy(
        update={
            "readable": readable,
            "settable": settable,
            "options": options,
            "echoed": readable and echoed,
            "code": code,
        }
    )


@dataclass(slots=True)
class _SourcePart:
    """A part as announced by one origin: in one announcement, or in several that agree on its command topics.

    Parts of different origins with the same *group* are one part.
    """

    part: Part
    origin: Origin
    sources: list[SourceRecord] = field(default_factory=list)
    group: int = 0


_Announced: TypeAlias = tuple[SourceRecord, Part]
_Occurrence: TypeAlias = tuple[SourceRecord, Part, _SourcePart]


@dataclass(slots=True)
class _Merged:
    """A part being merged; *number* is its index, *ways* its undisputed descriptions, preferred ones first.

    Ways are applied in the order of their origins, so that order of arrival does not matter. The part is only claimed
    if all announcements that describe it are those of *claimants*.
    """

    part: Part
    number: int
    source: SourceRecord
    places: list[tuple[int, PartPlace]] = field(default_factory=list)
    ways: list[Way] = field(default_factory=list)
    claimant: SourceRecord | None = None
    is_described: bool = False

    @property
    def hidden(self) -> set[PartPlace]:
        """The places that do not describe it, if any does."""
        if len(self.ways) in (0, len(self.places)):  # usually all describe it
            return set()
        return {place for _, place in self.places} - {way[0] for way in self.ways}

    def add(self, source: SourceRecord, part: Part, origin: Origin, topics: TopicOwnership) -> str:
        """Add *part* of *source*; return its conflict over a command topic in words, empty for none."""
        place = (*source.key, part.id)
        self.places.append((source.number, place))
        if source.is_claimed:
            self.claimant = self.claimant or source
            return ""
        self.is_described = True
        conflict = topics.conflict(source, part)
        if not conflict:
            self.ways.append((place, origin, part, source.sighting))
        return conflict


class MergedParts(NamedTuple):
    """The parts of a device.

    Attributes:
        conflicts: The omitted parts and the reasons, in words.
        places: The part of the device for each part of a source, by gateway, key and part.
        claimed: The numbers of parts that only claimed announcements describe, if there are others.
        hidden: The places that report nothing of their parts, as others have a better right to describe these.
        has_own_ids: Whether it has all parts of all announcements under their announced ids.
    """

    parts: tuple[DevicePart, ...]
    conflicts: tuple[str, ...]
    places: dict[PartPlace, int]
    claimed: frozenset[int] = _NONE_CLAIMED
    hidden: frozenset[PartPlace] = _NONE_HIDDEN
    has_own_ids: bool = False

    @property
    def believed(self) -> tuple[DevicePart, ...]:
        """The parts that determine the type of the device."""
        if not self.claimed:
            return self.parts
        return tuple(part for number, part in enumerate(self.parts) if number not in self.claimed)

    def shown_part_of(self, source: SourceRecord, part: str) -> DevicePart | None:
        """Return the part that shows the values of *part* of *source*, or None."""
        place = (*source.key, part)
        number = self.places.get(place)
        return None if number is None or place in self.hidden else self.parts[number]

    def hiding(self, places: frozenset[PartPlace]) -> "MergedParts":
        """Return them with *places* hidden as well."""
        return self._replace(hidden=self.hidden | places, has_own_ids=False) if places else self

    def ids(self) -> dict[PartPlace, str]:
        """Return the id for each part of a source."""
        return {place: self.parts[number].id for place, number in self.places.items()}


def merge_parts(sources: Sequence[SourceRecord], topics: TopicOwnership, known: PartIds = NO_IDS) -> MergedParts:
    """Return the parts of the *sources* of one device, in order of preference; *known* parts keep their ids.

    Parts of different conventions or gateways are matched by :mod:`homebot.discovery.merging.matching`. Within one
    convention, parts are one only if they have the same id and topics, the same commands on the same topics, or are a
    sensor that several bridges receive. Otherwise two parts with the same id are in conflict, and the older one counts.
    """
    in_sources = [(source, part) for source in sources for part in source.sighting.parts]
    if len(sources) == 1 or _are_distinct(sources, in_sources):
        return _distinct_parts(in_sources, topics, known)
    conflicts: list[str] = []
    numbered: dict[int, _Merged] = {}
    places: dict[PartPlace, int] = {}
    left_out = 0
    for source, part, announced in _occurrences(sources, conflicts):
        merged_part = numbered.get(announced.group)
        if merged_part is None:
            if len(numbered) >= MAX_PARTS:
                left_out += 1
                continue
            merged_part = numbered[announced.group] = _Merged(part, len(numbered), source)
        places[(*source.key, part.id)] = merged_part.number
        if conflict := merged_part.add(source, part, announced.origin, topics):
            conflicts.append(conflict)
    if left_out:
        conflicts.append(_left_out(left_out))
    merged = tuple(numbered.values())
    claimed = {part.number: part.claimant for part in merged if part.claimant is not None and not part.is_described}
    conflicts += dict.fromkeys(map(_claim_conflict, claimed.values()))
    parts = _named(merged, known)
    return MergedParts(
        parts,
        tuple(conflicts),
        places,
        _NONE_CLAIMED if all(source.is_claimed for source in sources) else frozenset(claimed),
        has_own_ids=_has_own_ids(sources, parts, places),
    ).hiding(frozenset(chain.from_iterable(part.hidden for part in merged)))


def _has_own_ids(sources: Sequence[SourceRecord], parts: Sequence[DevicePart], places: Mapping[PartPlace, int]) -> bool:
    """Return whether all parts of *sources* are among *parts* under their own ids."""
    return len(places) == sum([len(source.sighting.parts) for source in sources]) and (
        [parts[number].id for number in places.values()] == [name for _, _, name in places]
    )


def main_part(parts: Sequence[DevicePart]) -> DevicePart | None:
    """Return the main part of a device: not a setting or diagnostic, and a lamp rather than its thermometer."""
    if len(parts) == 1:
        return parts[0]
    return min(
        parts, key=lambda one: (bool(one.part.category), _RANK.get(one.part.service_type, len(_RANK))), default=None
    )


def _are_distinct(sources: Sequence[SourceRecord], announced: Sequence[_Announced]) -> bool:
    """Return whether all parts of *sources* are announced once, by one trusted origin, as usual."""
    origin = _origin(sources[0])
    commands = [topics for topics in starmap(_commands_of, announced) if topics]
    return (
        not sources[0].is_claimed
        and all(_origin(source) == origin for source in sources)
        and len({(part.service_type, part.id) for _, part in announced}) == len(announced)
        and len(set(commands)) == len(commands)
    )


def _distinct_parts(announced: Sequence[_Announced], topics: TopicOwnership, known: PartIds) -> MergedParts:
    """Return the parts of a device of which nothing has to be matched."""
    conflicts: list[str] = []
    places: dict[PartPlace, int] = {}
    kept = announced[:MAX_PARTS]
    names = ids = [part.id for _, part in kept]
    if known or len(set(names)) < len(names):
        named = [Named(part.id, source.label, [(source.number, (*source.key, part.id))]) for source, part in kept]
        ids = list(part_ids(named, known))
    merged: list[DevicePart] = []
    for number, (source, part) in enumerate(kept):
        gateway, key = source.key
        places[gateway, key, part.id] = number
        routes: tuple[Route, ...] = ()
        if source.is_claimed:
            conflicts = [_claim_conflict(source)]
        elif conflict := topics.conflict(source, part):
            conflicts.append(conflict)
        else:
            route = _route_of(
                gateway=gateway,
                key=key,
                part=part.id,
                convention=source.sighting.convention,
                takes=EVERYTHING,
                approved="",
                topics=part.writes,
            )
            routes = (route,)
        merged.append(_part_of(id=ids[number], part=part, routes=routes))
    if left_out := len(announced) - len(kept):
        conflicts.append(_left_out(left_out))
    has_own_ids = not left_out and len(places) == len(names) and ids == names
    return MergedParts(tuple(merged), tuple(conflicts), places, has_own_ids=has_own_ids)


def _claim_conflict(source: SourceRecord) -> str:
    return f"{source.label} on {source.key[0]} only claims to be this device, and gets no commands; {CONFIRM}"


def _left_out(count: int) -> str:
    return f"{count} further parts are ignored; a device may have at most {MAX_PARTS:,}"


def _occurrences(sources: Sequence[SourceRecord], conflicts: list[str]) -> list[_Occurrence]:
    """Return each part of each source with the part of its origin; those of other devices are in *conflicts*."""
    occurrences: list[_Occurrence] = []
    origins: dict[Origin, list[_SourcePart]] = {}
    namesakes: dict[tuple[Origin, str, str], list[_SourcePart]] = {}
    repeated: dict[tuple[object, ...], _SourcePart] = {}
    for source in sources:
        origin = _origin(source)
        for part in source.sighting.parts:
            same_name = namesakes.setdefault((origin, part.service_type, part.id), [])
            older = (
                [candidate for candidate in same_name if candidate.sources[0] is not source] if same_name else same_name
            )
            commands = _commands_of(source, part)
            announced = _announced_before(part, older, source) or repeated.get((origin, *commands))
            if announced is None:
                if older and part.id:
                    conflicts.append(f"{source.label} announces {part.id!r}, which is {older[0].sources[0].label}'s")
                    continue
                announced = _SourcePart(part, origin)
                same_name.append(announced)
                origins.setdefault(origin, []).append(announced)
                if commands:
                    repeated[origin, *commands] = announced
            announced.sources.append(source)
            occurrences.append((source, part, announced))
    _group(origins)
    return occurrences


def _announced_before(part: Part, older: Iterable[_SourcePart], source: SourceRecord) -> _SourcePart | None:
    for candidate in older:
        if _same_topics(part, candidate.part) or (
            _is_relayed(source, part) and part.capabilities == candidate.part.capabilities
        ):
            return candidate
    return None


def _is_relayed(source: SourceRecord, part: Part) -> bool:
    """Return whether *part* is a sensor that several bridges may receive at once."""
    return source.sighting.native and not source.sighting.whole_device and not part.writes


def _group(origins: Mapping[Origin, Sequence[_SourcePart]]) -> None:
    """Give parts of different origins that are one part of the device the same group, an arbitrary number."""
    groups: list[list[Candidate]] = []
    for origin in sorted(origins):
        parts = origins[origin]
        if len(origins) == 1:
            for number, part in enumerate(parts):
                part.group = number
            return
        identifiers = chain.from_iterable(source.sighting.identifiers for part in parts for source in part.sources)
        described = candidates([part.part for part in parts], dict.fromkeys(identifiers))
        same = match(groups, described)
        for number, (part, candidate) in enumerate(zip(parts, described, strict=True)):
            part.group = same.get(number, len(groups))
            if part.group == len(groups):
                groups.append([])
            groups[part.group].append(candidate)


def _named(merged: Sequence[_Merged], known: PartIds) -> tuple[DevicePart, ...]:
    ids: Sequence[str] = [part.part.id for part in merged]
    if known or len(set(ids)) < len(ids):
        ids = part_ids([Named(part.part.id, part.source.label, part.places) for part in merged], known)
    return tuple(_device_part(part_id, part) for part_id, part in zip(ids, merged, strict=True))


def _device_part(part_id: str, one: _Merged) -> DevicePart:
    part = one.ways[0][2] if one.ways else one.part
    if len(one.ways) > 1:
        part = described_part(sorted(one.ways, key=lambda way: (not asks_by_itself(way[2]), way[1])))
    routes = tuple(
        _route_of(
            gateway=gateway,
            key=key,
            part=name,
            convention=origin[-1],
            takes=settable_by(described, part),
            approved="",
            topics=described.writes,
        )
        for (gateway, key, name), origin, described, _ in one.ways
    )
    return _part_of(id=part_id, part=part, routes=routes)


def _origin(source: SourceRecord) -> Origin:
    sighting = source.sighting
    return source.is_claimed, not sighting.native, sighting.gateway, sighting.convention


def _commands_of(source: SourceRecord, part: Part) -> tuple[object, ...]:
    """Return the facts that repeated announcements of *part* share; see :meth:`TopicUse.repeats`. Empty for none."""
    if not (part.payloads and part.writes) or len(source.sighting.parts) > 1:
        return ()
    return part.service_type, part.payloads, part.writes, part.reads


def _same_topics(part: Part, other: Part) -> bool:
    if part.writes or other.writes:
        return set(part.writes) == set(other.writes)
    return part.reads == other.reads
