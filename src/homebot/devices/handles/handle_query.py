"""Query for handles: a kind, and conditions on its parts. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Generic, ParamSpec, Protocol, TypeAlias, TypedDict, TypeVar

from homebot.devices.device import Device, DevicePart
from homebot.devices.handles.arguments import check_place, check_state
from homebot.devices.part import Category
from homebot.devices.query import (
    And,
    AreaIs,
    CanDo,
    FactIs,
    FreshnessIs,
    NameIs,
    Not,
    PartFacets,
    Query,
    ReachableIs,
    StateIs,
    TypeIs,
    fits,
)
from homebot.devices.query.folding import fold

if TYPE_CHECKING:
    from homebot.devices.handles.handle import Handle

__all__ = ["CommonFilters", "HandleQuery", "HandleType", "Term"]

HandleT = TypeVar("HandleT", bound="Handle")
P = ParamSpec("P")

Term: TypeAlias = CanDo | Not | StateIs
"""What can be asked of a part."""


class CommonFilters(TypedDict, total=False):
    """Filters that apply to every kind.

    Attributes:
        area: The room it is in, whatever the case and accents.
        name: What its device or the part is called, likewise.
        reachable: Whether it can be reached, as far as it says.
        fresh: Whether it spoke itself and is not silent for too long.
        category: ``"config"`` for settings and ``"diagnostic"`` for self-observations instead of what devices are there
            for: nobody who turns off all switches means the one of a lamp's own indicator.
    """

    area: str
    name: str
    reachable: bool
    fresh: bool
    category: Category


@dataclass(frozen=True, slots=True)
class HandleQuery(Generic[HandleT]):
    """The handles of a kind, of which something must be true.

    Attributes:
        kind: The class of the handles.
        place: What must be true of the device.
        terms: What must be true of the part itself.
        device_terms: All that must be true of the device.
        part_terms: All that must be true of the part.

    Raises:
        TypeError: A condition is unknown, or its value is of another type.
        ValueError: The category is none.
    """

    kind: type[HandleT]
    place: CommonFilters
    terms: tuple[Term, ...] = ()
    device_terms: tuple[Query, ...] = field(init=False)
    part_terms: tuple[Query, ...] = field(init=False)

    def __post_init__(self) -> None:
        check_place(self.kind.__name__, self.kind.wanted, self.place)
        for term in self.terms:
            if isinstance(term, StateIs):
                check_state(term)
        object.__setattr__(self, "device_terms", _device_terms(self.place))
        object.__setattr__(self, "part_terms", (*_part_terms(self.kind.service_types, self.place), *self.terms))

    def parts(self, device: Device) -> Iterator[str]:
        """Yield the ids of the parts of *device* that are wanted."""
        if not device.parts:
            return
        facets = PartFacets(device)
        for term in self.device_terms:
            if not fits(term, facets):
                return
        for part in _parts_in(device, self.place.get("category", "")):
            facets.part = part
            for term in self.part_terms:
                if not fits(term, facets):
                    break
            else:
                yield part.id

    def device_query(self) -> Query:
        """Return what narrows the search for devices down; what it finds beyond, :meth:`parts` leaves out."""
        terms: list[Query] = [term for term in self.terms if not isinstance(term, Not)]  # another part may be so
        if category := self.place.get("category", ""):
            terms.append(FactIs("category", category))  # devices are not found by the types of such parts
        elif self.kind.service_types:
            terms.append(_type_term(self.kind.service_types))
        if area := fold(self.place.get("area", "")):
            terms.append(AreaIs(area))
        return And(tuple(terms))


class HandleType(Protocol[P, HandleT]):
    """A class of handles, as ``find`` and ``follow`` take it: its ``wanted`` says what can be asked of it."""

    def wanted(self, *args: P.args, **kwargs: P.kwargs) -> HandleQuery[HandleT]:
        """Return what is asked for."""
        ...


def _parts_in(device: Device, category: Category) -> list[DevicePart]:
    """Settings and self-observations count unasked only where there is nothing else."""
    found = [one for one in device.parts if one.part.category == category]
    return found if found or category else list(device.parts)


def _device_terms(place: CommonFilters) -> tuple[Query, ...]:
    terms: list[Query] = []
    if "area" in place:
        terms.append(AreaIs(fold(place["area"])))
    if "fresh" in place:
        terms.append(FreshnessIs("fresh") if place["fresh"] else Not(FreshnessIs("fresh")))
    return tuple(terms)


def _part_terms(service_types: frozenset[str], place: CommonFilters) -> list[Query]:
    terms: list[Query] = [_type_term(service_types)] if service_types else []
    if "name" in place:
        terms.append(NameIs(fold(place["name"])))
    if "reachable" in place:
        terms.append(ReachableIs("yes" if place["reachable"] else "no"))
    return terms


def _type_term(service_types: frozenset[str]) -> TypeIs:
    return TypeIs("", service_types, by_word=False)
