"""Searchable properties of a device, case-folded and ready to compare. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from itertools import chain
from operator import attrgetter
from typing import Final

from homebot.devices.always_ask import waits_for_approval
from homebot.devices.device import Device, DevicePart
from homebot.devices.device_types import DEVICE_TYPES, wanted_types
from homebot.devices.part import Part
from homebot.devices.value import PlainValue
from homebot.support.bounded_map import BoundedMap
from homebot.support.folding import fold, words_of

_CONVENTION = attrgetter("convention")
_GATEWAY = attrgetter("gateway")
_MAX_WORDS = 48
"""The limit of searchable words of one device."""

_TEXTS = frozenset({"group", "manufacturer", "model", "model_id", "serial_number"})


@dataclass(frozen=True, slots=True)
class Facets:
    """The properties of a device that queries can ask for.

    Attributes:
        kinds: Type and tag of each main part; without parts, the type of its word, if that is unambiguous.
        advertised: The types in its announcements' own words, folded.
        possible_types: The types that the word of a device without parts may mean; empty for a device with parts.
        areas: Its room and the areas that contain it, folded.
        words: The words of its id, names, room, floor, tags and model, folded.
        categories: ``config`` and ``diagnostic``, if it has parts of these.
        facts: All facts by name, folded.
        values: Type of the part, capability, value, and the id of the part.
        named_parts: The ids of the parts that are called like a type that they are not, by that name, folded.
        main_type: Its primary type; without parts, its word.
        is_guessed: Whether the type of its first part was guessed.
        is_unapproved: Whether it is dangerous and not approved by the owner.
    """

    id: str
    name: str
    kinds: frozenset[tuple[str, str]]
    advertised: frozenset[str]
    possible_types: frozenset[str]
    capabilities: frozenset[str]
    settable: frozenset[str]
    areas: tuple[str, ...]
    tags: frozenset[str]
    words: tuple[str, ...]
    freshness: str
    reachable: str
    gateways: frozenset[str]
    conventions: frozenset[str]
    categories: frozenset[str]
    facts: Mapping[str, tuple[str, ...]]
    values: tuple[tuple[str, str, PlainValue, str], ...]
    named_parts: Mapping[str, frozenset[str]]
    main_type: str
    is_guessed: bool
    is_disputed: bool
    is_unapproved: bool

    @property
    def names(self) -> tuple[str, ...]:
        """Its id and names, folded."""
        return fold(self.id), self.name, *self.facts.get("name", ())


_MAX_KEPT: Final = 2000
_KEPT: BoundedMap[int, tuple[Device, Facets]] = BoundedMap(_MAX_KEPT)
"""The newest descriptions with their facets, by identity: a device that is kept is no other one's."""


def facets_of(device: Device) -> Facets:
    """Return the searchable facets of *device*."""
    kinds, possible_types = _kinds_of(device.service_type, device.parts)
    facts: dict[str, tuple[str, ...]] = {}
    for fact in device.facts:
        value = fold(fact.value)
        known = facts.get(fact.name)
        if known is None:
            facts[fact.name] = (value,)
        elif value not in known:
            facts[fact.name] = (*known, value)
    for item in device.metadata:
        if item.key not in facts:
            facts[item.key] = (fold(item.value),)
    (capabilities, settable, gateways, conventions, categories), named_parts = _sets_of(device)
    main = _main_part(device)
    return Facets(
        id=device.id,
        name=fold(device.name),
        kinds=kinds,
        advertised=frozenset(map(fold, device.service_types or (device.service_type,))),
        possible_types=possible_types,
        capabilities=capabilities,
        settable=settable,
        areas=_areas(device.area, device.outer_areas) if device.area else _NOWHERE,
        tags=frozenset(map(fold, device.tags)) if device.tags else _NO_TAGS,
        words=_words(device, facts),
        freshness=device.freshness,
        reachable=device.reachable.state,
        gateways=gateways,
        conventions=conventions,
        categories=categories,
        facts=facts,
        values=_values_of(device) if device.states else (),
        named_parts=named_parts,
        main_type=main.service_type if main is not None else device.service_type,
        is_guessed=main.guessed if main is not None else False,
        is_disputed=bool(device.conflicts),
        is_unapproved=waits_for_approval(device),
    )


def shared_facets_of(device: Device) -> Facets:
    """Return the facets of *device*, kept for the live queries of others: hundreds compare the same description."""
    known = _KEPT.get(id(device))
    if known is None or known[0] is not device:
        known = _KEPT[id(device)] = device, facets_of(device)
    return known[1]


def _main_part(device: Device) -> Part | None:
    """Return the part that determines the type of the device; None if there is none."""
    for part in device.parts:
        if device.service_type in (part.part.service_type, part.part.advertised):
            return part.part
    return None


def _sets_of(device: Device) -> tuple[list[frozenset[str]], Mapping[str, frozenset[str]]]:
    """Return the capabilities, the settable ones, gateways, conventions and categories of all parts; and parts by name.

    In one loop, because it runs after most messages of every device.
    """
    capabilities: set[str] = set()
    settable: set[str] = set()
    categories: set[str] = set()
    named_parts = _NO_PARTS
    gateways, conventions = set(map(_GATEWAY, device.endpoints)), set(map(_CONVENTION, device.facts))
    for part in device.parts:
        if part.part.category:
            categories.add(part.part.category)
        elif part.part.members and part.part.is_group:
            categories.add("group")
        for capability in part.part.capabilities:
            capabilities.add(capability.name)
            if capability.settable:
                settable.add(capability.name)
        if part.part.name and _is_named_like_another_type(part.part.name, part.part.service_type):
            name = fold(part.part.name)
            named_parts = {**named_parts, name: named_parts.get(name, frozenset()) | {part.id}}
        for route in part.routes:
            gateways.add(route.gateway)
            conventions.add(route.convention)
    return [*map(frozenset, (capabilities, settable, gateways, conventions, categories))], named_parts


def _values_of(device: Device) -> tuple[tuple[str, str, PlainValue, str], ...]:
    types = {part.id: part.part.service_type for part in device.parts}
    return tuple(
        [(types.get(state.part, ""), state.capability, state.value.plain(), state.part) for state in device.states]
    )


@lru_cache(maxsize=1024)
def _is_named_like_another_type(name: str, service_type: str) -> bool:
    meant = wanted_types(name)
    return bool(meant) and service_type not in meant


_NOWHERE: tuple[str, ...] = ()
_NO_TAGS: frozenset[str] = frozenset()
_NO_PARTS: Mapping[str, frozenset[str]] = {}


@lru_cache(maxsize=1024)
def _areas(area: str, outer_areas: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(dict.fromkeys(map(fold, (area, *outer_areas))))


def _kinds_of(service_type: str, parts: tuple[DevicePart, ...]) -> tuple[frozenset[tuple[str, str]], frozenset[str]]:
    """Return the kinds of a device, and the possible meanings of its word if it has no parts.

    Settings and diagnostics count only if there is nothing else: a query for switches does not mean the one that dims a
    lamp's own light.
    """
    if not parts:
        meant = wanted_types(service_type)
        sure = meant if len(meant) == 1 else frozenset()
        return frozenset((kind, "") for kind in sure | ({service_type} & DEVICE_TYPES.keys())), meant
    kinds: set[tuple[str, str]] = set()
    others: set[tuple[str, str]] = set()
    for part in parts:
        if not (part.part.members and part.part.is_group):
            (others if part.part.category else kinds).add((part.part.service_type, part.part.tag))
    return frozenset(kinds or others), frozenset()


def _words(device: Device, facts: Mapping[str, tuple[str, ...]]) -> tuple[str, ...]:
    texts = [device.id, *device.names, device.name, device.area]
    if len(device.outer_areas) > 1 or device.tags:
        texts += (*device.outer_areas[:-1], *device.tags)  # without the home, which contains all
    for name, values in facts.items():
        if name in _TEXTS:
            texts += values
    for part in device.parts:
        if not part.part.category:
            texts.append(part.part.name)
    return tuple(dict.fromkeys(chain.from_iterable(map(words_of, texts))))[:_MAX_WORDS]
