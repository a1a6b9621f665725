"""Queries for handles: a kind, and conditions on its parts. Pure."""

from __future__ import annotations

import inspect
import math
from collections.abc import Mapping
from typing import (
    TYPE_CHECKING,
    Final,
    Generic,
    ParamSpec,
    Protocol,
    TypeAlias,
    TypedDict,
    TypeVar,
    get_args,
)

from homebot.devices.capabilities import CAPABILITIES
from homebot.devices.device import Device
from homebot.devices.part import Category
from homebot.devices.query.matching import PartFacets, fits
from homebot.devices.query.terms import (
    FIELDS,
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    IsNear,
    NameIs,
    Not,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
    leaves,
)
from homebot.support.folding import fold
from homebot.support.names import did_you_mean

if TYPE_CHECKING:
    from homebot.devices.handles.handle import Handle

HandleT = TypeVar("HandleT", bound="Handle")
P = ParamSpec("P")

Term: TypeAlias = CanDo | Not | StateIs
"""A condition on a part."""

_CUTOFF = 0.7
_CATEGORIES = get_args(Category)


class CommonFilters(TypedDict, total=False):
    """Filters that apply to every kind.

    Attributes:
        area: The room of the device, or its floor or home, ignoring case and accents; empty for a device without a
            room.
        name: A name of the device or part, ignoring case and accents.
        tag: A tag of the device, ignoring case and accents.
        reachable: Whether it reports that it can be reached.
        fresh: Whether it reported recently.
        category: ``"config"`` for settings and ``"diagnostic"`` for diagnostics, instead of the main functions of
            devices: "turn off all switches" does not mean the switch of a lamp's own indicator.
        near: The name of a robot; ``find`` returns the nearest handles first.
        within: The longest way from that robot through doors, in metres.
        optional: Whether a house may lack such devices, so that no warning says so and no test fails.
    """

    area: str
    name: str
    tag: str
    reachable: bool
    fresh: bool
    category: Category
    near: str
    within: float
    optional: bool


_FILTER_TYPES: Mapping[str, type] = {
    **dict.fromkeys(("area", "name", "tag", "category", "near"), str),
    **dict.fromkeys(("reachable", "fresh", "optional"), bool),
    "within": float,
}


class HandleQuery(Generic[HandleT]):
    """A query for the handles of a kind.

    Args:
        terms: Conditions on the part itself.

    Attributes:
        search: The query for the devices that may have such parts; :meth:`parts` decides.
        asks_for_values: Whether there is a condition on a value, so that each new value may change the matches.
        near: The condition to be near a robot, which only the directory can check; None if there is none.
        names: The conditions that a house may lack for good: the type, an area, a tag, a name of a device.

    Raises:
        TypeError: A filter is unknown, or a value is of another type.
        ValueError: There is no such category, or *within* is not a length or has no robot.
    """

    def __init__(self, kind: type[HandleT], filters: CommonFilters, terms: tuple[Term, ...] = ()) -> None:
        _check(kind, filters, terms)
        self._category: Final = filters.get("category", "")
        types: list[Query] = [TypeIs("", kind.service_types, by_word=False)] if kind.service_types else []
        self._types: Final = types
        places: list[Query] = [AreaIs(fold(filters["area"]))] if "area" in filters else []
        if "tag" in filters:
            places.append(FactIs("tag", fold(filters["tag"])))
        names: list[Query] = [NameIs(fold(filters["name"]))] if "name" in filters else []
        part_terms = [*types, *names]
        if "reachable" in filters:
            part_terms.append(ReachableIs("yes" if filters["reachable"] else "no"))
        self._device_terms: Final = [*places, *_freshness(filters)] if "fresh" in filters else places
        self._part_terms: Final = (*part_terms, *terms)
        self._filters: Final = filters
        self._terms: Final = terms
        self.kind: Final = kind
        named = places[1:] if filters.get("area") == "" else places  # the empty name means no room
        self.names: Final = () if filters.get("optional") else (*types, *named, *names)
        self.near: Final = _near(filters) if "near" in filters or "within" in filters else None
        self.search: Final[Query] = self._search(types, places, terms)
        self.asks_for_values: Final = bool(terms) and _contain_values(terms)

    def _search(self, types: list[Query], places: list[Query], terms: tuple[Term, ...]) -> Query:
        """Return the query for the devices that may have such a part; with a category, no type is required."""
        searched: list[Query] = [term for term in terms if not isinstance(term, Not)]  # another part may match it
        searched += [FactIs("category", self._category)] if self._category else types
        return And((*searched, *places) if self.near is None else (*searched, *places, self.near))

    def narrowed(self, more: HandleQuery[HandleT]) -> HandleQuery[HandleT]:
        """Return the query with the additional conditions of *more*."""
        return HandleQuery(self.kind, {**self._filters, **more._filters}, (*self._terms, *more._terms))

    @property
    def exact_values(self) -> tuple[str, ...]:
        """The capabilities that must have an exact value."""
        return tuple([term.capability for term in self._terms if isinstance(term, StateIs) and term.operator == "="])

    @property
    def near_search(self) -> Query | None:
        """The query for the devices of the kind that are near enough, regardless of values; None for any position."""
        return None if self.near is None else And((*self._types, self.near))

    def parts(self, device: Device) -> list[str]:
        """Return the ids of the parts of *device* that match.

        Unless a category is given, settings and diagnostics match only if the device has no other parts.
        """
        matching: list[str] = []
        if not device.parts:
            return matching
        facets = PartFacets(device)
        for term in self._device_terms:
            if not fits(term, facets):
                return matching
        parts = [part for part in device.parts if part.part.category == self._category]
        for part in parts if parts or self._category else device.parts:
            facets.part = part
            for term in self._part_terms:
                if not fits(term, facets):
                    break
            else:
                matching.append(part.id)
        return matching


def _freshness(filters: CommonFilters) -> list[Query]:
    fresh = FreshnessIs("fresh")
    return [fresh if filters["fresh"] else Not(fresh)]


def _contain_values(terms: tuple[Term, ...]) -> bool:
    return any(isinstance(leaf, StateIs) for term in terms for leaf in leaves(term))


def _near(filters: CommonFilters) -> IsNear | None:
    if "near" not in filters:
        if "within" in filters:
            raise ValueError("within is the way from a robot: give its name as near, for example near='robot'")
        return None
    within = filters.get("within", math.inf)
    if not within >= 0:
        raise ValueError(f"within is a number of metres from 0, not {within!r}")
    return IsNear(filters["near"], float(within))


class HandleType(Protocol[P, HandleT]):
    """A class of handles for ``find`` and ``follow``: the parameters of ``where`` are its conditions."""

    def where(self, *args: P.args, **kwargs: P.kwargs) -> HandleQuery[HandleT]:
        """Return the query with these conditions."""
        ...


def _check(kind: type[Handle], filters: CommonFilters, terms: tuple[Term, ...]) -> None:
    """Refuse an unknown condition, which would otherwise match the whole house."""
    for name, value in filters.items():
        if name not in _FILTER_TYPES:
            raise TypeError(f"{kind.__name__} cannot be filtered by {name!r}: {_hint(kind, name)}")
        expected = _FILTER_TYPES[name]
        is_number = expected is float and type(value) is int
        if not (is_number or isinstance(value, expected)):
            raise TypeError(f"{name} is {_called(expected)}, not {value!r}")
    if (category := filters.get("category", "")) not in _CATEGORIES:
        known = " or ".join(repr(category) for category in _CATEGORIES if category)
        raise ValueError(f"category is {known}, not {category!r}")
    for term in terms:
        if not isinstance(term, StateIs) or term.capability not in CAPABILITIES:
            continue
        expected = {"bool": bool, "number": float, "text": str}.get(CAPABILITIES[term.capability].kind, tuple)
        if not isinstance(term.value, expected):
            raise TypeError(f"{term.capability} is {_called(expected)}, not {term.value!r}")


def _hint(kind: type[Handle], name: str) -> str:
    known = [parameter for parameter in inspect.signature(kind.where).parameters if parameter != "filters"] + list(
        _FILTER_TYPES
    )
    meant = [FIELDS[name]] if FIELDS.get(name) in known else known
    return did_you_mean(FIELDS.get(name, name), meant, f"it takes {', '.join(sorted(known))}", _CUTOFF)


def _called(kind: type) -> str:
    return {str: "a text", bool: "True or False", float: "a number", tuple: "several numbers"}[kind]
