"""Test of a query against a device or one of its parts. Pure."""

from __future__ import annotations

from collections.abc import Mapping

from homebot.devices.always_ask import waits_for_approval
from homebot.devices.device import Device, DevicePart
from homebot.devices.query.facets import Facets, facets_of
from homebot.devices.query.terms import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    GatewayIs,
    HasText,
    InArea,
    IsDisputed,
    IsUnapproved,
    NameIs,
    Not,
    Or,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
)
from homebot.devices.value import PlainValue
from homebot.support.folding import fold, is_typo

__all__ = ["PartFacets", "compares", "fits"]


class PartFacets:
    """The properties of one part of a device that queries can ask for, each worked out when it is asked for.

    Args:
        device: The device; it has parts.

    Attributes:
        part: The part, at first the first one.
    """

    __slots__ = ("_device", "part")

    def __init__(self, device: Device) -> None:
        self._device = device
        self.part: DevicePart = device.parts[0]

    @property
    def id(self) -> str:
        """The id of its device."""
        return self._device.id

    @property
    def name(self) -> str:
        """The name of its device, folded."""
        return fold(self._device.name)

    @property
    def names(self) -> frozenset[str]:
        """Id and names of its device, and its own name, folded."""
        device, own = self._device, self.part.part.name
        return frozenset([fold(name) for name in (device.id, device.name, *device.names, *((own,) if own else ()))])

    @property
    def kinds(self) -> frozenset[tuple[str, str]]:
        """Its type and tag."""
        return frozenset(((self.part.part.service_type, self.part.part.tag),))

    @property
    def advertised(self) -> frozenset[str]:
        """Its advertised type, folded."""
        return frozenset((fold(self.part.part.advertised or self.part.part.service_type),))

    @property
    def possible_types(self) -> frozenset[str]:
        """Nothing: a part has one type."""
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
    def values(self) -> list[tuple[str, str, PlainValue]]:
        """Its type, capability, and value, for each value."""
        part, service_type = self.part.id, self.part.part.service_type
        return [
            (service_type, state.capability, state.value.plain()) for state in self._device.states if state.part == part
        ]

    @property
    def areas(self) -> tuple[str, ...]:
        """The room of its device and the areas that this is in, folded; empty if no room is known."""
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
        """Its category, if it has one."""
        return frozenset((self.part.part.category,)) if self.part.part.category else frozenset()

    @property
    def facts(self) -> Mapping[str, tuple[str, ...]]:
        """The facts of its device by name, folded."""
        return facets_of(self._device).facts

    @property
    def is_disputed(self) -> bool:
        """True when anything about its device is disputed."""
        return bool(self._device.conflicts)

    @property
    def is_unapproved(self) -> bool:
        """True when its device can hurt and the owner has not approved it."""
        return waits_for_approval(self._device)


def fits(query: Query, device: Facets | PartFacets) -> bool:
    """Return whether *device*, or one part of it, matches *query*."""
    match query:
        case And(terms):
            fits_all = True
            for term in terms:  # no generator: handles are looked at with every state
                fits_all = fits_all and fits(term, device)
            return fits_all
        case Or(terms):
            return any(fits(term, device) for term in terms)
        case Not(term):
            return not fits(term, device)
        case TypeIs():
            return (
                (query.by_word and query.word in device.advertised)
                or True in map(query.matches, device.kinds)
                or (bool(device.possible_types) and device.possible_types == query.types)
            )
        case CanDo(name, settable):
            return name in (device.settable if settable else device.capabilities)
        case StateIs():
            return any(
                capability == query.capability
                and (not query.types or service_type in query.types)
                and compares(query, value)
                for service_type, capability, value in device.values
            )
        case AreaIs(area):
            return area in device.areas if area else not device.areas
        case HasText(word):
            return any(one.startswith(word) or is_typo(word, one) for one in device.words)
        case _:
            return _fits_whole(query, device)


def _fits_whole(
    query: InArea | NameIs | FreshnessIs | ReachableIs | GatewayIs | FactIs | IsDisputed | IsUnapproved,
    device: Facets | PartFacets,
) -> bool:
    match query:
        case IsDisputed():
            return device.is_disputed
        case IsUnapproved():
            return device.is_unapproved
        case NameIs(name):
            return name in device.names
        case InArea(area):
            areas = device.areas
            return area in areas or any(_begins(one, area) for one in areas)
        case FreshnessIs(freshness):
            return device.freshness == freshness
        case ReachableIs(state):
            return device.reachable == state
        case GatewayIs(gateway):
            return gateway in device.gateways
        case FactIs(name, value):
            return _fits_fact(name, value, device)


def _fits_fact(name: str, value: str, device: Facets | PartFacets) -> bool:
    match name:
        case "id":
            return device.id.casefold() == value
        case "name" if _begins(device.name, value):
            return True
        case "tag":
            return value in device.tags
        case "convention":
            return value in device.conventions
        case "category":
            return value in device.categories
        case _:
            return any(_begins(fact, value) for fact in device.facts.get(name, ()))


def compares(term: StateIs, value: PlainValue) -> bool:
    """Return whether *value* satisfies *term*."""
    wanted = term.value
    if value is None:
        return False
    if isinstance(value, str) and isinstance(wanted, str):
        return (fold(value) == wanted) == (term.operator == "=")
    if isinstance(value, bool) or isinstance(wanted, bool):
        return isinstance(value, bool) and isinstance(wanted, bool) and (value is wanted) == (term.operator == "=")
    if not isinstance(value, float) or not isinstance(wanted, float):
        return False
    match term.operator:
        case "=":
            return value == wanted
        case "!=":
            return value != wanted
        case "<":
            return value < wanted
        case "<=":
            return value <= wanted
        case ">":
            return value > wanted
        case ">=":
            return value >= wanted


def _begins(text: str, wanted: str) -> bool:
    return text == wanted or text.startswith(f"{wanted} ")
