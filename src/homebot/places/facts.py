"""Facts about devices that the owner states, positions among them. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

from homebot.errors import UsageError
from homebot.places.plan import HouseDoor, HouseRoom

__all__ = [
    "CLOSED_DOOR",
    "NO_PLACES",
    "OWNER_ERROR",
    "TAG_ERROR",
    "FactName",
    "OwnerFact",
    "Places",
    "Position",
    "read_position",
]

OWNER_ERROR = 0.1
"""Metres by which a position may be wrong that the owner states."""

CLOSED_DOOR = 3.0
"""Metres that going through a closed door counts besides the way, if none are stated."""

TAG_ERROR = 0.3
"""Metres for one that a tag says."""

_FARTHEST = 10_000.0

FactName: TypeAlias = Literal["area", "position", "name", "tag", "taught_area", "taught_position"]


class Position(NamedTuple):
    """A position in the house.

    Attributes:
        x: Metres in the frame ``map``.
        y: Metres in the frame ``map``.
        floor: The floor; empty where that is not stated.
        error: Metres by which it may be wrong.
        source: How it was stated; empty where that is not known.
    """

    x: float
    y: float
    floor: str = ""
    error: float = OWNER_ERROR
    source: str = ""

    @property
    def text(self) -> str:
        """The position, floor and error as text, such as ``3.2,1,Attic ±0.1 m``."""
        floor = f",{self.floor}" if self.floor else ""
        return f"{self.x:.12g},{self.y:.12g}{floor} ±{self.error:g} m"


class OwnerFact(NamedTuple):
    """A fact about a device stated by the owner; it outranks the device's own.

    Attributes:
        name: ``area`` for the room, ``position`` as :attr:`Position.text`, ``name`` for an alias, ``tag``, or
            ``taught_area`` and ``taught_position`` for what an NFC tag or a code at the device says, used only without
            any other statement.
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
        devices: The facts of each device, by the ids and hardware addresses that it is known by.
    """

    rooms: tuple[HouseRoom, ...] = ()
    devices: Mapping[tuple[str, ...], tuple[OwnerFact, ...]] = field(default_factory=dict)
    doors: tuple[HouseDoor, ...] = ()
    closed_door: float = CLOSED_DOOR


NO_PLACES = Places()


def read_position(text: str, error: float = OWNER_ERROR, source: str = "") -> Position:
    """Return the position of a text ``X,Y[,FLOOR][ ±ERROR m]``; ``+-`` will do for ``±``.

    Args:
        error: Its error, if the text has none.

    Raises:
        UsageError: It is no such text, or a number is not finite or beyond 10 km.
    """
    place, _, stated = text.replace("+-", "±").partition("±")
    x, y, floor = (*place.split(",", 2), "", "")[:3]
    try:
        position = Position(float(x), float(y), floor.strip(), float(stated.removesuffix("m") or error), source)
    except ValueError:
        raise UsageError(f"{text!r} is no position; write X,Y or X,Y,FLOOR in metres, such as 3.2,1.0") from None
    if not all(abs(one) <= _FARTHEST for one in (position.x, position.y)) or not 0 <= position.error <= _FARTHEST:
        raise UsageError(f"the position {position.text!r} is not within {_FARTHEST:,.0f} m")
    return position
