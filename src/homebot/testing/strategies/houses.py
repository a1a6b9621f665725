"""Random houses. The simplest has one room and nothing in it."""

from collections.abc import Collection, Sequence
from functools import lru_cache
from itertools import count
from typing import Final

from hypothesis import strategies as st
from hypothesis.strategies import DrawFn, SearchStrategy

from homebot.config import Table
from homebot.errors import UsageError
from homebot.house.rooms import OUTSIDE
from homebot.testing.day_event import write_time
from homebot.testing.strategies.choices import MADE, chosen, moments, one_of, optional, several, target
from homebot.testing.strategies.devices import FAULT_SETTINGS, KIND_SETTINGS, commands, devices

ROOMS: Final = ("hall", "kitchen", "living", "bedroom", "bath", "study", "nursery", "attic", "cellar", "garage")
PEOPLE: Final = ("anna", "ben", "clara", "david", "emma", "finn")
NO_DOOR: Final = ""
MAX_HABITS = 4
MAX_DEVICES = 50

_house = optional(
    {
        "seed": st.integers(0, 1000),
        "first_day": st.integers(1, 366),
        "latitude": st.integers(-60, 70).map(float),
        "by_hand": st.booleans(),
    }
)
_more = st.booleans()
_metres = st.integers(0, 12).map(float)
_room = optional({"x": _metres, "y": _metres, "window": st.sampled_from((0.0, 0.01, 0.1, 1.0))})
_times = moments(86_340.0, 60.0).map(write_time)


def houses(
    *,
    max_rooms: int = 4,
    min_devices: int = 0,
    max_devices: int = 5,
    max_people: int = 2,
    max_errands: int = 2,
    kinds: Collection[str] | None = None,
    faults: bool | Collection[str] = True,
) -> SearchStrategy[Table]:
    """Return a strategy for houses, each as the tables that :func:`homebot.house.description.parse_world` takes.

    All rooms are joined by doors. A house shrinks towards one room, no devices, no people, and no settings.

    Args:
        max_rooms: Rooms at most, 1 to 10.
        min_devices: Devices at least.
        max_devices: Devices at most, 0 to 50.
        max_people: People at most, 0 to 6.
        max_errands: Errands at most, 0 to 50.
        kinds: Kinds of devices, as the files name them; None is all.

    Raises:
        UsageError: A bound is out of its range, or a kind or fault is not known.
    """
    which = tuple(KIND_SETTINGS) if kinds is None else chosen(kinds, KIND_SETTINGS, "kind of device")
    max_devices = max_devices if which else 0
    for name, bound, low, high in (
        ("max_rooms", max_rooms, 1, len(ROOMS)),
        ("max_people", max_people, 0, len(PEOPLE)),
        ("max_devices", max_devices, 0, MAX_DEVICES),
        ("min_devices", min_devices, 0, max_devices),
        ("max_errands", max_errands, 0, MAX_DEVICES),
    ):
        if not low <= bound <= high:
            raise UsageError(f"{name} must be from {low} to {high}, got {bound}")
    wrong = tuple(FAULT_SETTINGS) if faults is True else chosen(faults or (), FAULT_SETTINGS, "fault")
    return _houses(max_rooms, (min_devices, max_devices), max_people, max_errands, which, wrong)


@st.composite
def _houses(
    draw: DrawFn,
    max_rooms: int,
    how_many: tuple[int, int],
    max_people: int,
    max_errands: int,
    kinds: tuple[str, ...],
    faults: tuple[str, ...],
) -> Table:
    tables: Table = {"house": draw(_house)}
    rooms, doors = draw(_plans(max_rooms))
    tables["rooms"] = rooms
    things: dict[str, Table] = {}
    if kinds:
        device = devices(tuple(rooms), doors, kinds, faults)
        tables["devices"] = things = _named(several(draw, device, *how_many))
    people = draw(_people((*rooms, OUTSIDE), max_people))
    tables["people"] = dict(zip(PEOPLE, people, strict=False))
    if things:
        tables["errands"] = draw(
            _errands(tuple((name, str(thing["kind"])) for name, thing in things.items()), max_errands)
        )
    return {name: table for name, table in tables.items() if table}


@st.composite
def _plans(draw: DrawFn, max_rooms: int) -> tuple[dict[str, Table], list[tuple[str, str]]]:
    """Draw rooms, each with a door to an earlier one or to the outside, and all their doors."""
    rooms: dict[str, Table] = {}
    pairs: list[tuple[str, str]] = []
    while not rooms or (draw(_more) and len(rooms) < max_rooms):
        name = ROOMS[len(rooms)]
        before = (OUTSIDE, *rooms)
        room = draw(_room)
        doors = {draw(one_of(before)): None, draw(one_of((NO_DOOR, *before))): None}
        doors.pop(NO_DOOR, None)
        rooms[name] = {**room, "doors": [*doors]}
        pairs += [(name, door) for door in doors]
    return rooms, pairs


@st.composite
def _person(draw: DrawFn, rooms: tuple[str, ...]) -> Table:
    table: Table = draw(_bodies(rooms))
    if day := draw(_habits(rooms)):
        table["day"] = day
    return table


@lru_cache(MADE)
def _people(rooms: tuple[str, ...], at_most: int) -> SearchStrategy[list[Table]]:
    return st.lists(_person(rooms), max_size=at_most)


@lru_cache(MADE)
def _bodies(rooms: tuple[str, ...]) -> SearchStrategy[Table]:
    return optional({"starts_in": one_of(rooms), "asleep": st.booleans(), "speed": st.sampled_from((1.0, 0.1, 10.0))})


@lru_cache(MADE)
def _habits(rooms: tuple[str, ...]) -> SearchStrategy[list[Table]]:
    more = optional({"jitter": st.sampled_from((60.0, 600.0, 3600.0)), "asleep": st.booleans()})
    habit = st.builds(lambda at, room, options: {"at": at, "room": room, **options}, _times, one_of(rooms), more)
    return st.lists(habit, max_size=MAX_HABITS)


@lru_cache(MADE)
def _errands(things: tuple[tuple[str, str], ...], at_most: int) -> SearchStrategy[list[Table]]:
    return st.lists(_schedule_command(things), max_size=at_most)


@st.composite
def _schedule_command(draw: DrawFn, things: tuple[tuple[str, str], ...]) -> Table:
    at = draw(_times)
    device, kind = draw(target(things))
    return {"at": at, "device": device, "command": draw(commands(kind))}


def _named(tables: Sequence[Table]) -> dict[str, Table]:
    """Give each a name after its kind: ``lamp``, ``lamp2``."""
    named: dict[str, Table] = {}
    for table in tables:
        kind = str(table["kind"])
        names = (kind if number == 1 else f"{kind}{number}" for number in count(1))
        named[next(name for name in names if name not in named)] = table
    return named
