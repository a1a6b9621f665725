"""Facts about devices that the owner states, including positions. Pure."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

from homebot.errors import UsageError
from homebot.places.plan import HouseDoor, HouseRoom

OWNER_ERROR = 0.1
"""The default error of a position stated by the owner, in metres."""

CLOSED_DOOR = 3.0
"""The default cost of going through a closed door, in metres."""

TAG_ERROR = 0.3
"""The default error of a position from a tag, in metres."""

_FARTHEST = 10_000.0

FactName: TypeAlias = Literal["area", "position", "name", "tag", "taught_area", "taught_position"]


class Position(NamedTuple):
    """A position in the house.

    Attributes:
        x: Metres in the frame ``map``.
        y: Metres in the frame ``map``.
        floor: The floor; empty if it is not stated.
        error: Metres by which it may be wrong.
        source: How it was stated; empty if unknown.
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
    """A fact about a device stated by the owner; it takes precedence over the device's own.

    Attributes:
        name: ``area`` for the room, ``position`` as :attr:`Position.text`, ``name`` for an alias, ``tag``, or
            ``taught_area`` and ``taught_position`` from an NFC tag or a code on the device, or from a robot that
            saw it, used only without any other statement.
        source: How it was stated: ``configuration``, ``command`` or ``import``; for a taught room, the gateway and the
        number of the tag, separated by ``/``, or ``seen``.
        said_at: When it was stated, in seconds since the Unix epoch.
    """

    name: FactName
    value: str
    source: str
    said_at: float


@dataclass(frozen=True, slots=True)
class Places:
    """A validated table ``[places]``.

    Attributes:
        devices: The facts of each device, by its ids and hardware addresses.
        groups: The queries for the members of groups, by name: the tables ``[[groups]]``.
    """

    rooms: tuple[HouseRoom, ...] = ()
    devices: Mapping[tuple[str, ...], tuple[OwnerFact, ...]] = field(default_factory=dict)
    doors: tuple[HouseDoor, ...] = ()
    closed_door: float = CLOSED_DOOR
    groups: Mapping[str, str] = field(default_factory=dict)


NO_PLACES = Places()


def read_position(text: str, error: float = OWNER_ERROR, source: str = "") -> Position:
    """Parse a position ``X,Y[,FLOOR][ ±ERROR m]``; ``+-`` is accepted for ``±``.

    Args:
        error: Its error, if the text has none.

    Raises:
        UsageError: The text is invalid, or a number is not finite or beyond 10 km.
    """
    place, _, stated = text.replace("+-", "±").partition("±")
    x, y, floor = (*place.split(",", 2), "", "")[:3]
    try:
        position = Position(float(x), float(y), floor.strip(), float(stated.removesuffix("m") or error), source)
    except ValueError:
        raise UsageError(f"{text!r} is not a position; write X,Y or X,Y,FLOOR in metres, such as 3.2,1.0") from None
    if (
        not all(abs(coordinate) <= _FARTHEST for coordinate in (position.x, position.y))
        or not 0 <= position.error <= _FARTHEST
    ):
        raise UsageError(f"the position {position.text!r} is not within {_FARTHEST:,.0f} m")
    return position
