"""The description of a device: the result of its announcements and of the owner's statements. Pure."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain, filterfalse
from operator import attrgetter
from typing import Final

import homebot.places
from homebot.devices import Device, DevicePart, Fact, KeyValue, Sighting
from homebot.devices.always_ask import APPROVED, CHANGED, CLAIMED_MODEL, MAKE, PANEL, always_asks
from homebot.devices.device_types import wanted_types
from homebot.devices.names import OWNER, PREFER, SEEN, SEVERAL_NAMES, TAG
from homebot.devices.words import SIREN, matching_words
from homebot.discovery.approvals import Approval
from homebot.discovery.endpoints import Addresses, addresses, preferred_routes, rank_in
from homebot.discovery.ids import name_without
from homebot.discovery.merging.part_ids import PartIds, PartPlace
from homebot.discovery.merging.parts import MergedParts, main_part, merge_parts
from homebot.discovery.owner_facts import OwnerFacts
from homebot.discovery.source_record import SourceKey, SourceRecord, preference
from homebot.discovery.topics.ownership import TopicOwnership
from homebot.errors import UsageError
from homebot.messages import Time
from homebot.places import NO_AREAS, HousePlan, OwnerFact, Position, read_position
from homebot.support.folding import fold

MAX_FACTS = 200
"""Most published facts of one device; those of the preferred announcements come first."""


@dataclass(slots=True)  # not frozen, which would cost a microsecond per announcement
class DeviceDescription:
    """The fields of a device that follow from its announcements and the owner's statements.

    The names are those of :class:`homebot.devices.Device`.

    Attributes:
        groups: The facts that name the groups of which it is a member; None if these are not found yet.
    """

    name: str
    names: tuple[str, ...]
    service_type: str
    service_types: tuple[str, ...]
    area: str
    identifiers: tuple[str, ...]
    metadata: tuple[KeyValue, ...]
    facts: tuple[Fact, ...]
    addresses: tuple[Addresses, ...]
    merged: MergedParts
    outer_areas: tuple[str, ...]
    tags: tuple[str, ...] = ()
    groups: tuple[Fact, ...] | None = None


def describe_device(
    sources: tuple[SourceRecord, ...], topics: TopicOwnership, known_ids: PartIds, owner: OwnerFacts | None
) -> DeviceDescription:
    """Return the description of an announced device."""
    ordered = sorted(sources, key=preference) if len(sources) > 1 else sources
    first = ordered[0].sighting
    merged = _with_sirens(merge_parts(ordered, topics, known_ids), first)
    parts = merged.believed
    main = main_part(parts)
    believed = ordered if len(ordered) == 1 else _believed(ordered, owner)
    area, outer_areas = next(filter(None, map(_AREA, believed)), ""), NO_AREAS
    facts = _facts(believed)
    if believed is not ordered:
        facts += _claimed_models(filterfalse(believed.__contains__, ordered))
    if len(ordered) > 1:
        facts += tuple(_several_names(facts))
    given = _given_in_hub(facts)
    if owner is not None:
        plan = owner.rooms.plan  # without a call, as this runs for every announcement
        if not area and plan.has_areas:
            area = _room_at(facts, plan)
        if area:
            floor = _floor_of(believed, area) if given["floor"] else ""
            area, outer_areas = plan.locate_on(area, floor)
    name = next(filter(None, map(_NAME, believed)), "") or name_without(first)
    return DeviceDescription(
        name=name,
        names=tuple(dict.fromkeys(filter(None, (*map(_NAME, believed), *given["aliases"])))) or (name,),
        service_type=first.service_type if main is None or first.is_plain_text else main.part.service_type,
        service_types=_service_types(believed, parts),
        area=area,
        outer_areas=outer_areas,
        identifiers=tuple(dict.fromkeys(chain.from_iterable(map(_IDENTIFIERS, ordered)))),
        metadata=first.metadata if len(ordered) == 1 else _metadata(believed),
        facts=facts,
        addresses=addresses(ordered, main),
        merged=merged,
        tags=tuple(dict.fromkeys(given["tags"])),
    )


def without_parts_of(strangers: Collection[SourceKey], device: Device, merged: MergedParts) -> Device:
    """Return *device* without the parts that *strangers* alone describe, except for those that always ask."""
    known = {number for (gateway, key, _), number in merged.places.items() if (gateway, key) not in strangers}
    shown = {number: part for number, part in enumerate(device.parts) if number in known or always_asks(device, part)}
    believed = tuple(part for number, part in shown.items() if number not in merged.claimed)
    if len(shown) == len(device.parts) or (main := main_part(believed)) is None:
        return device
    before = main_part(merged.believed)
    is_of_part = before is not None and device.service_type == before.part.service_type
    return device.model_copy(
        update={
            "parts": tuple(shown.values()),
            "service_type": main.part.service_type if is_of_part else device.service_type,
            "service_types": _service_types((), believed),
            "offline_parts": tuple(
                offline_part
                for offline_part in device.offline_parts
                if offline_part in {part.id for part in shown.values()}
            ),
        }
    )


_TYPE: Final = attrgetter("service_type")
_ADVERTISED: Final = attrgetter("advertised")
_CATEGORY: Final = attrgetter("category")
_PART: Final = attrgetter("part")
_PART_TYPE: Final = attrgetter("part.service_type")
_IS_CLAIMED: Final = attrgetter("is_claimed")
_PAIR: Final = attrgetter("key", "value")
_NAME: Final = attrgetter("sighting.name")
_AREA: Final = attrgetter("sighting.area")
_IDENTIFIERS: Final = attrgetter("sighting.identifiers")


def _believed(sources: Sequence[SourceRecord], owner: OwnerFacts | None) -> Sequence[SourceRecord]:
    """Return those of *sources* that say something of their device: nothing that joined an approved device does."""
    believed = tuple(filterfalse(_IS_CLAIMED, sources)) or sources
    return believed if owner is None else owner.approvals.filter_approved(believed) or believed


def _claimed_models(sources: Iterable[SourceRecord]) -> tuple[Fact, ...]:
    made = [fact for fact in _facts(tuple(sources)) if fact.name in MAKE]
    return tuple(fact.model_copy(update={"name": CLAIMED_MODEL}) for fact in made)


def _several_names(facts: Iterable[Fact]) -> Iterator[Fact]:
    """Yield a fact if announcements of one convention give the device several names: perhaps it is several devices."""
    names = [fact for fact in facts if fact.name == "name"]
    for first in names:
        alike = {fold(fact.value): fact.value for fact in names if _SOURCE(fact) == _SOURCE(first)}
        if len(alike) > 1:
            value = f"names {', '.join(alike.values())}"[:_MAX_NAMES]
            yield first.model_copy(update={"name": SEVERAL_NAMES, "value": value})
            return


_SOURCE: Final = attrgetter("gateway", "convention")
_MAX_NAMES: Final = 300
_RELAYS: Final = frozenset({"plug", "switch"})


def _with_sirens(merged: MergedParts, sighting: Sighting) -> MergedParts:
    """Return *merged* with the type ``siren`` for relays named like one, so that "all switches on" sounds none.

    For the only relay of a device, the names of device and model count too.
    """
    if _RELAYS.isdisjoint(map(_PART_TYPE, merged.parts)):
        return merged
    relays = [number for number, part in enumerate(merged.parts) if part.part.service_type in _RELAYS]
    about = (sighting.name, *[item.value for item in sighting.metadata if item.key == "model"])
    parts = list(merged.parts)
    for number in relays:
        part = parts[number].part
        names = (part.name, *about) if len(relays) == 1 else (part.name,)
        if not part.category and any(matching_words(name, SIREN) for name in names):
            siren = part.model_copy(update={"service_type": "siren", "advertised": "", "guessed": True})
            parts[number] = parts[number].model_copy(update={"part": siren})
    return merged._replace(parts=tuple(parts))


def with_stated_facts(
    described: DeviceDescription, stated: tuple[OwnerFact, ...], plan: HousePlan
) -> DeviceDescription:
    """Return the description of a device from its announcements and statements.

    The owner's statements outrank announcements, which outrank a tag; the facts are in this order.
    """
    own = [_state_fact(fact) for fact in stated if not fact.name.startswith(_TAUGHT)]
    taught = [_state_fact(fact) for fact in stated if fact.name.startswith(_TAUGHT)]
    names = tuple(dict.fromkeys((*_values(own, "name"), described.name, *described.names)))
    area, outer_areas = described.area, described.outer_areas
    if stated_area := _area_of(own, plan) or (not area and _area_of(taught, plan)):
        stated_area, stated_outer = plan.locate(stated_area)
        if fold(stated_area) != fold(area):
            outer_areas = stated_outer
        area = stated_area
    return replace(
        described,
        name=names[0],
        names=names,
        area=area,
        outer_areas=outer_areas,
        tags=tuple(dict.fromkeys((*_values(own, "tag"), *described.tags))),
        facts=((*own, *described.facts)[: MAX_FACTS - len(taught)] + tuple(taught)),
    )


_TAUGHT: Final = "taught_"


_POSITIONS: Final = frozenset({"position", "txt_position"})
"""The key of the fact in Thing Descriptions (``homebot:facts``) and in DNS-SD (TXT)."""

_ANNOUNCED_ERROR: Final = 2.0
"""Error in metres of a position announced without one."""


def position_of(facts: Iterable[Fact]) -> Position | None:
    """Return the first position among the *facts* of a device, or None."""
    for fact in facts:
        if fact.name in _POSITIONS:
            source = fact.key if fact.convention == OWNER else fact.convention or fact.gateway
            source = SEEN if fact.gateway == SEEN else source
            try:
                return read_position(fact.value, _ANNOUNCED_ERROR, source)
            except UsageError:  # a device's own use of the key for something else
                continue
    return None


def _given_in_hub(facts: Iterable[Fact]) -> dict[str, list[str]]:
    """Return the aliases, tags and floors given to a device in a hub, which separates them by commas."""
    values: dict[str, list[str]] = {"aliases": [], "tags": [], "floor": []}
    for fact in facts:
        if fact.name in values:
            values[fact.name] += filter(None, map(str.strip, fact.value.split(",")))
    return values


def _floor_of(sources: Iterable[SourceRecord], area: str) -> str:
    """Return the floor in the announcement that places the device in *area*; empty for none."""
    rooms = (source.sighting for source in sources if fold(source.sighting.area) == fold(area))
    return next((pair.value for room in rooms for pair in room.metadata if pair.key == "floor"), "")


def _values(facts: Iterable[Fact], name: str) -> Iterator[str]:
    return (fact.value for fact in facts if fact.name == name)


def _area_of(facts: Sequence[Fact], plan: HousePlan) -> str:
    """Return the room stated by *facts*, or else the room at their position; empty for none."""
    return next(_values(facts, "area"), "") or _room_at(facts, plan)


def _room_at(facts: Iterable[Fact], plan: HousePlan) -> str:
    """Return the room at the position in *facts*; empty for none."""
    position = position_of(facts) if plan.has_areas else None
    place = None if position is None else homebot.places.FloorPlan.of(plan).place_of(position)
    return "" if place is None else place.room


def with_approvals(
    described: DeviceDescription, approvals: Sequence[tuple[PartPlace, Approval, str]]
) -> DeviceDescription:
    """Return the description with the owner's approvals: the approved routes, and what changed at others."""
    digests = {place: approval.description.digest for place, approval, change in approvals if not change}
    facts = [
        _owner_fact(CHANGED, change, *place[:2], approval.said_at) for place, approval, change in approvals if change
    ]
    if digests:
        newest = max(approval.said_at for _, approval, change in approvals if not change)
        facts.insert(0, _owner_fact(APPROVED, "yes", "", "command", newest))
    if not facts:
        return described
    parts = [_with_approved_routes(part, digests) for part in described.merged.parts]
    joined = frozenset(_join(parts, frozenset(place for place, _, _ in approvals)))
    return replace(
        described,
        merged=described.merged._replace(parts=tuple(parts)).hiding(joined),
        facts=(*facts, *described.facts)[:MAX_FACTS],
    )


def _join(parts: Iterable[DevicePart], known: frozenset[PartPlace]) -> Iterator[PartPlace]:
    """Yield the places that joined approved parts; of a part that changed since, only those never approved."""
    for part in parts:
        places = {(route.gateway, route.key, route.part): route.approved for route in part.routes}
        approved = {place for place, digest in places.items() if digest} or known & places.keys()
        if approved:
            yield from places.keys() - approved


def _with_approved_routes(part: DevicePart, digests: Mapping[PartPlace, str]) -> DevicePart:
    approved = [digests.get((route.gateway, route.key, route.part), "") for route in part.routes]
    if not any(approved):
        return part
    routes = [
        route.model_copy(update={"approved": digest}) for route, digest in zip(part.routes, approved, strict=True)
    ]
    return part.model_copy(update={"routes": tuple(routes)})


def with_panel(described: DeviceDescription, panel: str, said_at: Time) -> DeviceDescription:
    """Return the description of a device that hangs on the alarm panel with the identifier *panel*."""
    fact = Fact(name=PANEL, value=panel, gateway="", convention="", key="", said_at=said_at)
    return replace(described, facts=(fact, *described.facts)[:MAX_FACTS])


def with_doubts(described: DeviceDescription, doubts: tuple[str, ...]) -> DeviceDescription:
    """Return the description of a device with identifiers that count for nothing, in words, as *doubts*."""
    return replace(described, merged=described.merged._replace(conflicts=(*doubts, *described.merged.conflicts)))


def with_preferred_routes(described: DeviceDescription, prefer: Sequence[str], said_at: float) -> DeviceDescription:
    """Return the description of a device of several gateways with its routes in the order *prefer*, a fact too."""
    gateways = {gateway for (gateway, _), _, _ in described.addresses}
    named = [gateway for gateway in prefer if gateway in gateways]
    if len(gateways) == 1 or not named:
        return described
    fact = _owner_fact(PREFER, ", ".join(named), "", "configuration", said_at)
    return replace(
        described,
        addresses=tuple(sorted(described.addresses, key=lambda address: rank_in(prefer, address[0][0]))),
        merged=described.merged._replace(parts=preferred_routes(described.merged.parts, prefer)),
        facts=(fact, *described.facts)[:MAX_FACTS],
    )


def _owner_fact(name: str, value: str, gateway: str, key: str, said_at: float, convention: str = OWNER) -> Fact:
    at = Time.from_seconds(said_at)
    return Fact(name=name, value=value, gateway=gateway, convention=convention, key=key, said_at=at)


def _state_fact(fact: OwnerFact) -> Fact:
    if not fact.name.startswith(_TAUGHT):
        return _owner_fact(fact.name, fact.value, "", fact.source, fact.said_at)
    gateway, _, key = fact.source.partition("/")
    return _owner_fact(fact.name.removeprefix(_TAUGHT), fact.value, gateway, key, fact.said_at, TAG)


def _service_types(sources: Sequence[SourceRecord], parts: tuple[DevicePart, ...]) -> tuple[str, ...]:
    if parts:
        described = tuple(map(_PART, parts))
        shown = tuple(filterfalse(_CATEGORY, described)) or described
        service_types = chain(map(_TYPE, shown), filter(None, map(_ADVERTISED, shown)))
    else:
        words = [source.sighting.service_type for source in sources]
        service_types = chain((min(types) for types in map(wanted_types, words) if len(types) == 1), words)
    return tuple(dict.fromkeys(service_types))


def _metadata(sources: Sequence[SourceRecord]) -> tuple[KeyValue, ...]:
    key_values: dict[str, KeyValue] = {}
    before: tuple[KeyValue, ...] = ()
    for source in sources:
        metadata = source.sighting.metadata
        if metadata != before:  # the announcements of a device share them
            for item in metadata:
                key_values.setdefault(item.key, item)
            before = metadata
    return tuple(key_values.values())[:MAX_FACTS]


def _facts(sources: Sequence[SourceRecord]) -> tuple[Fact, ...]:
    """Return each value once per gateway and convention, from the first announcement that has it."""
    facts: dict[tuple[str, str, str, str], Fact] = {}
    before: tuple[object, ...] = ()
    for source in sources:
        sighting = source.sighting
        gateway, convention = sighting.gateway, sighting.convention
        announced = gateway, convention, sighting.name, sighting.area, sighting.metadata
        if announced == before:
            continue
        before = announced
        at = source.first_seen
        for name, value in (("name", sighting.name), ("area", sighting.area), *map(_PAIR, sighting.metadata)):
            if value and (fact := (name, value, gateway, convention)) not in facts:
                changed_value, changed_at = source.facts.get(name, ("", at))
                said_at = changed_at if changed_value == value else at
                facts[fact] = Fact(
                    name=name, value=value, gateway=gateway, convention=convention, key=sighting.key, said_at=said_at
                )
        if len(facts) >= MAX_FACTS:
            break
    return tuple(facts.values())[:MAX_FACTS]
