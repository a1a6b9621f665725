"""Query for handles: a kind, and conditions on its parts. Pure."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Generic, ParamSpec, Protocol, TypeAlias, TypedDict, TypeVar

from homebot.devices.device import Device, DevicePart
from homebot.devices.handles.arguments import check_place, check_state
from homebot.devices.part import Category
from homebot.devices.query import CanDo, Not, Query, StateIs, quoted
from homebot.devices.query.folding import fold
from homebot.devices.query.terms import compares
from homebot.devices.value import PlainValue

if TYPE_CHECKING:
    from homebot.devices.handles.handle import Handle

__all__ = ["CommonFilters", "HandleQuery", "HandleType", "Term"]

HandleT = TypeVar("HandleT", bound="Handle")
P = ParamSpec("P")

Term: TypeAlias = CanDo | Not | StateIs
"""What can be asked of a part."""

_PLAIN_NUMBER = re.compile(r"-?\d{1,15}\.\d{1,15}")


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

    Raises:
        TypeError: A condition is unknown, or its value is of another type.
        ValueError: The category is none.
    """

    kind: type[HandleT]
    place: CommonFilters
    terms: tuple[Term, ...] = ()

    def __post_init__(self) -> None:
        check_place(self.kind.__name__, self.kind.wanted, self.place)
        for term in self.terms:
            if isinstance(term, StateIs):
                check_state(term)

    def parts(self, device: Device) -> Iterator[str]:
        """Yield the ids of the parts of *device* that are wanted."""
        if not self._wants_device(device):
            return
        values = {(one.part, one.capability): one.value.plain() for one in device.states} if self.terms else {}
        for one in _parts_in(device, self.place.get("category", "")):
            is_wanted = self._wants_type(one.part.service_type) and self._wants_name(device, one.part.name)
            if not is_wanted or not self._wants_reach(device, one.id):
                continue
            if not self.terms or all(_fits(term, one, values) for term in self.terms):
                yield one.id

    def query(self) -> str:
        """Return as text what narrows the search down; what it finds beyond, :meth:`parts` leaves out."""
        asked = []
        if category := self.place.get("category", ""):
            asked.append(f"category={category}")  # devices are not found by the types of such parts
        elif self.kind.service_types:
            asked.append(f"({' or '.join(f'type={quoted(one)}' for one in sorted(self.kind.service_types))})")
        if fold(self.place.get("area", "")):
            asked.append(f"area={quoted(fold(self.place['area']))}")
        return " and ".join([*asked, *(text for term in self.terms if (text := _as_text(term)))])

    def _wants_type(self, service_type: str) -> bool:
        return not self.kind.service_types or service_type in self.kind.service_types

    def _wants_device(self, device: Device) -> bool:
        place = self.place
        return ("area" not in place or fold(device.area) == fold(place["area"])) and (
            "fresh" not in place or (device.freshness == "fresh") == place["fresh"]
        )

    def _wants_reach(self, device: Device, part: str) -> bool:
        if "reachable" not in self.place:
            return True
        state = "no" if part in device.offline_parts else device.reachable.state
        return state == ("yes" if self.place["reachable"] else "no")

    def _wants_name(self, device: Device, part: str) -> bool:
        if "name" not in self.place:
            return True
        wanted = fold(self.place["name"])
        return wanted in {fold(one) for one in (device.id, device.name, *device.names, *((part,) if part else ()))}


class HandleType(Protocol[P, HandleT]):
    """A class of handles, as ``find`` and ``follow`` take it: its ``wanted`` says what can be asked of it."""

    def wanted(self, *args: P.args, **kwargs: P.kwargs) -> HandleQuery[HandleT]:
        """Return what is asked for."""
        ...


def _parts_in(device: Device, category: Category) -> list[DevicePart]:
    """Settings and self-observations count unasked only where there is nothing else."""
    found = [one for one in device.parts if one.part.category == category]
    return found if found or category else list(device.parts)


def _as_text(term: Query) -> str:
    """Only what can be spelt exactly."""
    match term:
        case CanDo(name, True):
            return f"can={name}"
        case StateIs(capability, operator, bool(value)):
            return f"{capability}{operator}{'true' if value else 'false'}"
        case StateIs(capability, operator, str(value)) if value:
            return f"{capability}{operator}{quoted(value)}"
        case StateIs(capability, operator, float(value)) if _PLAIN_NUMBER.fullmatch(repr(value)):
            return f"{capability}{operator}{value!r}"
        case _:
            return ""


def _fits(term: Query, part: DevicePart, values: dict[tuple[str, str], PlainValue]) -> bool:
    match term:
        case StateIs():
            return compares(term, values.get((part.id, term.capability)))
        case CanDo(name, settable):
            return any(one.name == name and (one.settable or not settable) for one in part.part.capabilities)
        case Not(inner):
            return not _fits(inner, part, values)
        case _:
            return False
