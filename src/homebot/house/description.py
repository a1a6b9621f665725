"""A house described in TOML: its rooms, devices with their faults, people and timers.

::

    [house]
    seed = 1
    dialect = "thesis"                      # the dialect of devices without one of their own
    pace = 60.0                             # speed relative to the clock, from a time of day on
    begins = "06:30"

    [rooms.hall]
    doors = ["outside", "kitchen"]          # each door once, in either room

    [rooms.kitchen]
    x = 4.0                                 # metres

    [devices.kitchen_lamp]
    kind = "lamp"
    room = "kitchen"
    rated_watts = 12.0                      # the settings of a kind: docs/house.md
    faults = { lossy = { share = 0.1 } }    # from the device outwards

    [people.anna]
    starts_in = "kitchen"
    day = [{ at = "08:00", room = "outside", jitter = 600.0 }]

    [[errands]]
    at = "22:00"
    every = "30m"                           # again until midnight
    device = "kitchen_lamp"
    command = "off"
"""

import math
import random
import tomllib
from collections.abc import Container, Iterator, Mapping
from datetime import time
from pathlib import Path
from typing import Annotated

from pydantic import BaseModel, ConfigDict, Field

from homebot.config import Table, parse_settings
from homebot.errors import ConfigError, UsageError
from homebot.house.family import family_names, kinds_of
from homebot.house.faults import unwrap
from homebot.house.household import Habit, Person
from homebot.house.kinds import FAULTS, KINDS, Surroundings
from homebot.house.rooms import DAY, OUTSIDE, Room, Rooms, WorldTime
from homebot.house.sensors import PowerMeter
from homebot.house.simulated_device import DEFAULT_DIALECT, Placed, ScheduledCommand, SimulatedDevice
from homebot.house.world import World
from homebot.support.names import unknown_key
from homebot.support.toml_file import read_toml
from homebot.units import DURATION

Metres = Annotated[float, Field(allow_inf_nan=False)]
_Extent = Annotated[float, Field(ge=0.0, le=1000.0, allow_inf_nan=False)]


def family_world() -> World:
    """Return the house of ``homebot run``: a family's, with two robots, at 60 times speed from a dark morning on.

    Devices of integrations that were taken out are not in it.
    """
    file = Path(__file__).parent / "family" / "house.toml"
    tables, dialects = tomllib.loads(file.read_text("utf-8")), family_names()
    devices = {
        name: table
        for name, table in tables["devices"].items()
        if table.get("dialect", tables["house"]["dialect"]) in dialects
    }
    devices = {name: table for name, table in devices.items() if table.get("of", name) in devices}
    errands = [errand for errand in tables["errands"] if errand["device"] in devices]
    return parse_world({**tables, "devices": devices, "errands": errands}, str(file))


def office_world() -> World:
    """Return an office of two floors, with doors, a lift and three robots."""
    return load_world(Path(__file__).parent / "office" / "house.toml")


def load_world(path: Path, *, seed: int | None = None) -> World:
    """Return the house that the TOML file *path* describes, at its first midnight.

    Args:
        seed: Overrides that of the file.

    Raises:
        ConfigError: The file cannot be read or is no TOML, or as :func:`parse_world`.
    """
    return parse_world(read_toml(path), str(path), seed=seed)


def parse_world(tables: Mapping[str, object], source: str, *, seed: int | None = None) -> World:
    """Return the house that *tables* describe.

    Raises:
        ConfigError: A key is unknown, a value wrong, or a room or device not there; names *source*, key and reason.
    """
    parts = parse_settings(_Parts, tables, source, "")
    house = parse_settings(_HouseTable, parts.house, source, "house")
    seed = house.seed if seed is None else seed
    rooms = _rooms(parts.rooms, source)
    placed = [_place(name, table, rooms, seed, house.dialect, source) for name, table in parts.devices.items()]
    people = [_person(name, table, rooms, source) for name, table in parts.people.items()]
    known = {item.device.device_id for item in placed}
    for metered in placed:
        meter = unwrap(metered.device)
        if isinstance(meter, PowerMeter) and meter.of and meter.of not in known:
            raise ConfigError(source, f"devices.{meter.device_id}.of", f"there is no device {meter.of!r}")
    errands = [
        errand
        for number, table in enumerate(parts.errands)
        for errand in _schedule(f"errands.{number}", table, known, source)
    ]
    return World(
        rooms,
        placed,
        people,
        errands,
        seed=seed,
        first_day=house.first_day,
        latitude=house.latitude,
        by_hand=house.by_hand,
        forgetful=house.forgetful,
        time=WorldTime(house.pace, None if house.begins is None else _seconds(house.begins)),
    )


def _schedule(key: str, table: Table, known: Container[str], source: str) -> Iterator[ScheduledCommand]:
    scheduled = parse_settings(_ScheduledCommandTable, table, source, key)
    if scheduled.device not in known:
        raise ConfigError(source, f"{key}.device", f"there is no device {scheduled.device!r}")
    at = _seconds(scheduled.at)
    times = math.ceil((DAY - at) / scheduled.every) if scheduled.every else 1
    for number in range(times):
        yield ScheduledCommand(at + number * scheduled.every, scheduled.device, scheduled.command)


class _Strict(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class _Parts(_Strict):
    """The tables of a file; ``day`` and ``happenings``, of a saved day, are not the house's."""

    house: Table = Field(default_factory=dict)
    rooms: dict[str, Table]
    devices: dict[str, Table] = Field(default_factory=dict)
    people: dict[str, Table] = Field(default_factory=dict)
    errands: list[Table] = Field(default_factory=list)
    day: Table = Field(default_factory=dict)
    happenings: list[Table] = Field(default_factory=list)


class _HouseTable(_Strict):
    seed: int = 0
    first_day: int = Field(default=80, ge=1, le=366)
    latitude: float = Field(default=48.0, ge=-90.0, le=90.0)
    by_hand: bool = True
    forgetful: bool = False
    dialect: str = DEFAULT_DIALECT
    pace: float = Field(default=1.0, gt=0.0, le=1000.0)
    begins: time | None = None


class _RoomTable(_Strict):
    x: Metres = 0.0
    y: Metres = 0.0
    window: float = Field(default=0.01, ge=0.0, le=1.0)
    size: tuple[_Extent, _Extent] = (0.0, 0.0)
    doors: tuple[str, ...] = ()


class _PlaceTable(_Strict):
    room: str
    door: str = ""
    at: tuple[Metres, Metres] | None = None
    dialect: str | None = None
    faults: dict[str, Table] = Field(default_factory=dict)


class _HabitTable(_Strict):
    at: time
    room: str
    jitter: Annotated[float, DURATION] = Field(default=0.0, ge=0.0, le=43_200.0)
    asleep: bool = False
    still: Annotated[float, DURATION] = Field(default=0.0, ge=0.0, le=86_400.0)


class _PersonTable(_Strict):
    starts_in: str = OUTSIDE
    asleep: bool = True
    speed: float = Field(default=1.0, gt=0.0, allow_inf_nan=False)
    day: tuple[_HabitTable, ...] = ()


class _ScheduledCommandTable(_Strict):
    at: time
    every: Annotated[float, DURATION] = Field(default=0.0, ge=60.0, le=86_400.0)
    device: str
    command: str


def _rooms(tables: Mapping[str, Table], source: str) -> Rooms:
    rooms = {OUTSIDE: Room(window=1.0)}
    doors: list[tuple[str, str]] = []
    for name, table in tables.items():
        room = parse_settings(_RoomTable, table, source, f"rooms.{name}")
        rooms[name] = Room(room.x, room.y, room.window, *room.size)
        doors += [(name, other) for other in room.doors]
    for name, other in doors:
        _known(other, rooms, source, f"rooms.{name}.doors")
    return Rooms(rooms, tuple(doors))


def _place(name: str, table: Table, rooms: Rooms, seed: int, dialect: str, source: str) -> Placed:
    key = f"devices.{name}"
    kind = table.get("kind")
    if not isinstance(kind, str) or kind not in KINDS:
        raise ConfigError(source, f"{key}.kind", f"must be one of {', '.join(KINDS)}, got {kind!r}")
    where = ("room", "door", "at", "dialect", "faults")
    place = parse_settings(_PlaceTable, {k: v for k, v in table.items() if k in where}, source, key)
    _known(place.room, rooms.rooms, source, f"{key}.room")
    _known(place.door or place.room, rooms.rooms, source, f"{key}.door")
    stated_at = "house.dialect" if place.dialect is None else f"{key}.dialect"
    dialect = dialect if place.dialect is None else place.dialect
    kinds_there = kinds_of(dialect)
    if kinds_there is None:
        raise ConfigError(source, stated_at, f"must be one of {', '.join(family_names())}, got {dialect!r}")
    if kind not in kinds_there:
        kinds = ", ".join(sorted(kinds_there))
        raise ConfigError(source, f"{key}.dialect", f"{dialect!r} has no {kind}, only {kinds}")
    own = {k: v for k, v in table.items() if k not in {*where, "kind"}}
    rng = random.Random(f"{seed}/{name}")  # noqa: S311  # numbers of a game, no secrets
    device = parse_settings(KINDS[kind], own, source, key).build(Surroundings(name, place.room, rooms, rng))
    for fault, fault_table in place.faults.items():
        device = _faulty(device, fault, fault_table, rng, source, f"{key}.faults.{fault}")
    return Placed(device, place.room, place.door, dialect, place.at)


def _faulty(
    device: SimulatedDevice, fault: str, table: Table, rng: random.Random, source: str, key: str
) -> SimulatedDevice:
    if fault not in FAULTS:
        raise ConfigError(source, key, unknown_key(fault, FAULTS))
    return parse_settings(FAULTS[fault], table, source, key).apply(device, rng)


def _person(name: str, table: Table, rooms: Rooms, source: str) -> Person:
    key = f"people.{name}"
    person = parse_settings(_PersonTable, table, source, key)
    _known(person.starts_in, rooms.rooms, source, f"{key}.starts_in")
    for number, habit in enumerate(person.day):
        where = f"{key}.day.{number}.room"
        _known(habit.room, rooms.rooms, source, where)
        try:
            rooms.path(person.starts_in, habit.room)
        except UsageError as exc:
            raise ConfigError(source, where, str(exc)) from exc
    day = tuple(Habit(_seconds(habit.at), habit.room, habit.jitter, habit.asleep, habit.still) for habit in person.day)
    return Person(name, day, person.starts_in, person.asleep, person.speed)


def _known(room: str, rooms: Mapping[str, Room], source: str, key: str) -> None:
    if room not in rooms:
        raise ConfigError(source, key, f"there is no room {room!r}")


def _seconds(at: time) -> float:
    return at.hour * 3600 + at.minute * 60 + at.second + at.microsecond / 1e6
