"""Facts about devices that the owner states. Pure."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal, NamedTuple, TypeAlias

from homebot.places.plan import HouseRoom

__all__ = ["NO_PLACES", "FactName", "OwnerFact", "Places"]

FactName: TypeAlias = Literal["area", "name", "tag", "taught_area"]


class OwnerFact(NamedTuple):
    """A fact about a device stated by the owner; it outranks the device's own.

    Attributes:
        name: ``area`` for the room, ``name`` for an alias, ``tag``, or ``taught_area`` for the room that an NFC tag or
            a code at the device says, used only without any other statement.
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
    """

    rooms: tuple[HouseRoom, ...] = ()
    devices: Mapping[tuple[str, ...], tuple[OwnerFact, ...]] = field(default_factory=dict)


NO_PLACES = Places()
