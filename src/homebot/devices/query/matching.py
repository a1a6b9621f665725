"""Matching of a query against a device or one of its parts. Pure."""

import operator
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

from homebot.devices.always_ask import waits_for_approval
from homebot.devices.device import Device, DevicePart
from homebot.devices.names import GROUP
from homebot.devices.query.facets import Facets, facets_of
from homebot.devices.query.terms import (
    OPENING_TAGS,
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    IsNear,
    IsUnapproved,
    NameIs,
    Not,
    Operator,
    Or,
    PartIs,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
)
from homebot.devices.value import PlainValue
from homebot.support.folding import fold


def groups_of(device: Device, part_id: str) -> list[str]:
    """Return the names of the groups of which a part of *device* is a member."""
    named = [
        (fact.value, fact.key.partition("#")[2]) for fact in device.facts if fact.name == GROUP and not fact.gateway
    ]
    return [name for name, parts in named if not parts or part_id in parts.split(",")]


class PartFacets:
    """The searchable properties of one part of a device, each computed on first use.

    Args:
        part: The part; by default the first one.
    """

    __slots__ = ("_device", "part")

    def __init__(self, device: Device, part: DevicePart | None = None) -> None:
        self._device = device
        self.part = device.parts[0] if part is None else part

    @property
    def id(self) -> str:
        """The id of its device."""
        return self._device.id

    @property
    def name(self) -> str:
        """The name of its device, folded."""
        return fold(self._device.name)

    @property
    def names(self) -> tuple[str, ...]:
        """Id and names of its device, and its own name, folded."""
        device, own = self._device, self.part.part.name
        return tuple([fold(name) for name in (device.id, device.name, *device.names, *((own,) if own else ()))])

    @property
    def kinds(self) -> frozenset[tuple[str, str]]:
        """Its type and tag; none for a group, whose members match."""
        part = self.part.part
        return frozenset() if part.is_group else frozenset(((part.service_type, part.tag),))

    @property
    def advertised(self) -> frozenset[str]:
        """Its advertised type, folded."""
        return frozenset((fold(self.part.part.advertised or self.part.part.service_type),))

    @property
    def possible_types(self) -> frozenset[str]:
        """Empty, because a part has one type."""
        return frozenset()

    @property
    def capabilities(self) -> frozenset[str]:
        """Names of its capabilities."""
        return frozenset([capability.name for capability in self.part.part.capabilities])

    @property
    def settable(self) -> frozenset[str]:
        """Names of its capabilities that can be set."""
        return frozenset([capability.name for capability in self.part.part.capabilities if capability.settable])

    @property
    def values(self) -> list[tuple[str, str, PlainValue, str]]:
        """Its type, capability, value and id, for each value."""
        part, service_type = self.part.id, self.part.part.service_type
        return [
            (service_type, state.capability, state.value.plain(), part)
            for state in self._device.states
            if state.part == part
        ]

    @property
    def named_parts(self) -> dict[str, frozenset[str]]:
        """Its id by its own name, if it is called like a type that it is not."""
        of_device = facets_of(self._device).named_parts
        return {name: ids & {self.part.id} for name, ids in of_device.items() if self.part.id in ids}

    @property
    def areas(self) -> tuple[str, ...]:
        """The room of its device and the areas that contain it, folded; empty if no room is known."""
        device = self._device
        return tuple(map(fold, (device.area, *device.outer_areas))) if device.area else ()

    @property
    def tags(self) -> frozenset[str]:
        """The tags of its device, folded."""
        return frozenset(map(fold, self._device.tags))

    @property
    def words(self) -> tuple[str, ...]:
        """The words of its device."""
        return facets_of(self._device).words

    @property
    def freshness(self) -> str:
        """The freshness of its device."""
        return self._device.freshness

    @property
    def reachable(self) -> str:
        """Reachability: ``yes``, ``no`` or ``unknown``."""
        return "no" if self.part.id in self._device.offline_parts else self._device.reachable.state

    @property
    def gateways(self) -> frozenset[str]:
        """Gateways of its routes."""
        return frozenset([route.gateway for route in self.part.routes])

    @property
    def conventions(self) -> frozenset[str]:
        """Conventions of its routes."""
        return frozenset([route.convention for route in self.part.routes])

    @property
    def categories(self) -> frozenset[str]:
        """Its category, if it has one; ``group`` for a group."""
        own = self.part.part.category or "group" * self.part.part.is_group
        return frozenset((own,)) if own else frozenset()

    @property
    def facts(self) -> Mapping[str, tuple[str, ...]]:
        """The facts of its device by name, folded, but only the groups of which it is a member itself."""
        facts = facets_of(self._device).facts
        if GROUP not in facts:
            return facts
        return {**facts, GROUP: tuple([fold(name) for name in groups_of(self._device, self.part.id)])}

    @property
    def is_disputed(self) -> bool:
        """True if anything about its device is disputed."""
        return bool(self._device.conflicts)

    @property
    def is_unapproved(self) -> bool:
        """True if its device is dangerous and not approved by the owner."""
        return waits_for_approval(self._device)


def fits(query: Query, device: Facets | PartFacets) -> bool:
    """Return whether *device*, or one part of it, matches *query* in full words: a search alone may guess."""
    return _TESTS[type(query)](query, device)


def compares(term: StateIs, value: PlainValue) -> bool:
    """Return whether *value* satisfies *term*; only numbers have an order."""
    wanted = term.value
    if isinstance(value, str):
        value = fold(value)
    if isinstance(value, float) and isinstance(wanted, float):
        return COMPARISONS[term.operator](value, wanted)
    is_comparable = isinstance(value, str | bool) and type(value) is type(wanted)
    return is_comparable and (value == wanted) == (term.operator == "=")


COMPARISONS: Final[Mapping[Operator, Callable[[float, float], bool]]] = {
    "=": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
"""The comparison of two numbers by each operator."""


def matches_kind(query: TypeIs, kind: tuple[str, str]) -> bool:
    """Return whether a part of the type and tag *kind* matches."""
    service_type, tag = kind
    if service_type not in query.types:
        return False
    return not query.tag or service_type not in _OPENINGS or tag in OPENING_TAGS[query.tag]


_OPENINGS: Final = frozenset({"closure", "contact_sensor"})


def _fits_type(query: TypeIs, device: Facets | PartFacets) -> bool:
    return (
        (query.by_word and query.word in device.advertised)
        or True in map(partial(matches_kind, query), device.kinds)
        or (bool(device.possible_types) and device.possible_types == query.types)
    )


def _fits_state(query: StateIs, device: Facets | PartFacets) -> bool:
    return any(
        capability == query.capability
        and (not query.types or service_type in query.types)
        and (not query.part or part in device.named_parts.get(query.part, ()))
        and compares(query, value)
        for service_type, capability, value, part in device.values
    )


def _is_in(query: InArea, device: Facets | PartFacets) -> bool:
    areas = device.areas
    return query.text in areas or any(_begins(area, query.text) for area in areas)


def _fits_fact(query: FactIs, device: Facets | PartFacets) -> bool:
    match query.name:
        case "id":
            return device.id.casefold() == query.value
        case "name" if _begins(device.name, query.value):
            return True
        case "tag":
            return query.value in device.tags
        case "convention":
            return query.value in device.conventions
        case "category":
            return query.value in device.categories
        case "group":
            return query.value in device.facts.get("group", ())
        case name:
            return any(_begins(fact, query.value) for fact in device.facts.get(name, ()))


def _begins(text: str, wanted: str) -> bool:
    return text == wanted or text.startswith(f"{wanted} ")


_TESTS: Final[Mapping[type[Query], Callable[[Any, Facets | PartFacets], bool]]] = {
    And: lambda query, device: all(fits(term, device) for term in query.terms),
    Or: lambda query, device: any(fits(term, device) for term in query.terms),
    Not: lambda query, device: not fits(query.term, device),
    TypeIs: _fits_type,
    CanDo: lambda query, device: query.name in (device.settable if query.settable else device.capabilities),
    StateIs: _fits_state,
    AreaIs: lambda query, device: query.text in device.areas if query.text else not device.areas,
    InArea: _is_in,
    NameIs: lambda query, device: query.text in device.names,
    PartIs: lambda query, device: query.text in device.named_parts,
    HasText: lambda query, device: query.text in device.words,
    FreshnessIs: lambda query, device: device.freshness == query.text,
    ReachableIs: lambda query, device: device.reachable == query.text,
    GatewayIs: lambda query, device: query.text in device.gateways,
    FactIs: _fits_fact,
    IsDisputed: lambda _, device: device.is_disputed,
    IsUnapproved: lambda _, device: device.is_unapproved,
    IsNear: lambda _query, _device: True,
}
"""The test of each kind of term."""
