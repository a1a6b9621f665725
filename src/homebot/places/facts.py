"""Facts about devices that the owner states, positions among them. Pure."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

from homebot.errors import UsageError
from homebot.places.plan import HouseDoor, HouseRoom

__all__ = [
    "ANNOUNCED_ERROR",
    "NO_PLACES",
    "OWNER_ERROR",
    "TAG_ERROR",
    "FactName",
    "OwnerFact",
    "Places",
    "Position",
    "position_of",
    "read_position",
]

OWNER_ERROR = 0.1
"""Metres by which a position may be wrong that the owner states."""

TAG_ERROR = 0.3
"""Metres for one that a tag says."""

ANNOUNCED_ERROR = 2.0
"""Metres for one that a device announces."""

_FARTHEST = 10_000.0

FactName: TypeAlias = Literal["area", "position", "name", "tag", "taught_area"]


class Position(NamedTuple):
    """A position in the house.

    Attributes:
        x: Metres in the frame ``map``.
        y: Metres in the frame ``map``.
        floor: The floor; empty where that is not stated.
        error: Metres by which it may be wrong.
        source: How it was stated; see :attr:`OwnerFact.source`.
        at: When, in seconds since the Unix epoch.
    """

    x: float
    y: float
    floor: str = ""
    error: float = OWNER_ERROR
    source: str = ""
    at: float = 0.0

    @property
    def text(self) -> str:
        """The position, floor and error as text, such as ``3.2,1,Attic ±0.1 m``."""
        floor = f",{self.floor}" if self.floor else ""
        return f"{self.x:.12g},{self.y:.12g}{floor} ±{self.error:g} m"


class OwnerFact(NamedTuple):
    """A fact about a device stated by the owner; it outranks the device's own.

    Attributes:
        name: ``area`` for the room, ``position`` as :attr:`Position.text`, ``name`` for an alias, ``tag``, or
            ``taught_area`` for the room that an NFC tag or a code at the device says, used only without any other
            statement.
        value: The value.
        source: How it was stated: ``configuration``, ``command`` or ``import``; of a taught room the gateway and the
            number of the tag, with ``/`` between.
        said_at: When, in seconds since the Unix epoch.
    """

    name: FactName
    value: str
    source: str
    said_at: float


@dataclass(frozen=True, slots=True)
class Places:
    """A table ``[places]``, checked.

    Attributes:
        rooms: The rooms.
        devices: The facts of each device, by the ids and hardware addresses that it is known by.
        doors: The doors of which more is stated than their rooms.
    """

    rooms: tuple[HouseRoom, ...] = ()
    devices: Mapping[tuple[str, ...], tuple[OwnerFact, ...]] = field(default_factory=dict)
    doors: tuple[HouseDoor, ...] = ()


NO_PLACES = Places()


def read_position(text: str, error: float = OWNER_ERROR, source: str = "", at: float = 0.0) -> Position:
    """Return the position of a text ``X,Y[,FLOOR][ ±ERROR m]``.

    Args:
        text: The text.
        error: Its error, if the text has none.
        source: See :class:`Position`.
        at: Likewise.

    Raises:
        UsageError: It is no such text, or a number is not finite or beyond 10 km.
    """
    place, _, stated = text.partition("±")
    x, y, floor = (*place.split(",", 2), "", "")[:3]
    try:
        numbers = float(x), float(y), float(stated.removesuffix("m") or error)
    except ValueError:
        raise UsageError(f"{text!r} is no position; write X,Y or X,Y,FLOOR in metres, such as 3.2,1.0") from None
    if not all(math.isfinite(one) and abs(one) <= _FARTHEST for one in numbers) or numbers[2] < 0:
        raise UsageError(f"the position {text!r} is not within {_FARTHEST:,.0f} m")
    return Position(numbers[0], numbers[1], floor.strip(), numbers[2], source, at)


def position_of(facts: Iterable[OwnerFact]) -> Position | None:
    """Return the first position among *facts*; None if there is none."""
    fact = next((one for one in facts if one.name == "position"), None)
    return None if fact is None else read_position(fact.value, source=fact.source, at=fact.said_at)
