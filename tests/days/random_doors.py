"""Random doors of a house: their contacts, what the owner states of them, and hands that open and close them."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Final

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from homebot.testing import Day
from homebot.testing.day_event import DayEvent

Table = dict[str, Any]

_MOST_HANDS: Final = 6


@dataclass(frozen=True)
class RandomDoors:
    """The doors of a house.

    Attributes:
        contacts: The table of each contact on a door, by its name.
        rooms: The table ``[places.rooms]``: the rooms, with the doors that the owner states; empty for none.
        guarded: The table ``[control.presence_guard.doors]``.
    """

    contacts: Mapping[str, Table]
    rooms: Table
    guarded: Mapping[str, list[str]]


@dataclass(frozen=True)
class _Door:
    """A door: whether it has a contact, and whether the owner states it."""

    has_contact: bool
    is_stated: bool


_DOORS: Final = st.sampled_from((*[_Door(True, True)] * 9, _Door(False, True), _Door(True, False), _Door(False, False)))


@st.composite
def random_doors(draw: DrawFn, rooms: Mapping[str, Table], faults: SearchStrategy[Table]) -> RandomDoors:
    """Draw what is on the doors of *rooms*; most have a contact, with one of *faults* or none, and are stated.

    The owner lists the contacts of a room where each door that is stated has one: a door that is not stated may be
    without.
    """
    doors = {(room, other): draw(_DOORS) for room, table in rooms.items() for other in table.get("doors", ())}
    contacts = {
        _name(one, other): {"kind": "contact", "room": one, "door": other, "faults": draw(faults)}
        for (one, other), door in doors.items()
        if door.has_contact
    }
    stated = {
        room: {"doors": [other for one, other in doors if one == room and doors[one, other].is_stated]}
        for room in rooms
    }
    guarded: dict[str, list[str]] = {}
    for room in rooms:
        own = {pair: door for pair, door in doors.items() if room in pair}
        listed = [_name(*pair) for pair, door in own.items() if door.has_contact]
        is_covered = all(door.has_contact for door in own.values() if door.is_stated)
        if listed and is_covered and draw(st.integers(0, 3)):
            guarded[room] = listed
    return RandomDoors(contacts, stated if draw(st.integers(0, 3)) else {}, guarded)


def hands_on_doors(day: Day, contacts: tuple[str, ...]) -> SearchStrategy[list[DayEvent]]:
    """Return a strategy for the doors and windows that hands open and close in *day*, by the names of *contacts*."""
    if not contacts:
        return st.just([])
    hand = st.builds(
        lambda at, name, command: DayEvent(day.start + at, "press", name, command),
        st.integers(0, int(day.length)),
        st.sampled_from(contacts),
        st.sampled_from(("close", "open")),
    )
    return st.lists(hand, max_size=_MOST_HANDS)


def _name(room: str, other: str) -> str:
    return f"{room}_{other}_door"
