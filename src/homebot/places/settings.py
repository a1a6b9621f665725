"""The table ``[places]`` in the configuration or a places file. Pure."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from homebot.config import parse_settings, value_errors
from homebot.errors import ConfigError, UsageError
from homebot.places.facts import CLOSED_DOOR, FactName, OwnerFact, Places, read_position
from homebot.places.floor_plan import FloorPlan
from homebot.places.plan import OUTSIDE, WIDTH, HouseDoor, HousePlan, HouseRoom, Point, Rings, door_name
from homebot.support.folding import fold
from homebot.support.names import no_such

_MAX_CHARACTERS = 100
_MAX_NAMES = 50
"""The limit of doors of a room, and of aliases, tags or identifiers of a device."""


def check_name(text: str) -> str:
    """Return *text*, the name of a room, device or tag, without surrounding blanks.

    Raises:
        UsageError: It is empty, longer than 100 characters, or contains an unprintable character.
    """
    name = text.strip()
    if not name:
        raise UsageError("a name is empty")
    if len(name) > _MAX_CHARACTERS:
        raise UsageError(f"a name has {len(name):,} characters; {_MAX_CHARACTERS} is the limit")
    if not name.isprintable():
        raise UsageError(f"{name!r} contains an unprintable character")
    if not fold(name):
        raise UsageError(f"{name!r} has no letter and no digit")
    return name


def _name(text: str) -> str:
    with value_errors():
        return check_name(text)


def _name_or_none(text: str) -> str:
    return _name(text) if text else ""


_Name: TypeAlias = Annotated[str, AfterValidator(_name)]
_Names: TypeAlias = Annotated[tuple[_Name, ...], Field(max_length=_MAX_NAMES)]
_OptionalName: TypeAlias = Annotated[str, AfterValidator(_name_or_none)]


def _tuples(value: object) -> object:
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _areas(value: object) -> object:
    """Return the polygons of a room from corners, from rings as in a GeoJSON Polygon, or from a list of these."""
    depth, inner = 0, value
    while isinstance(inner, list) and inner:
        depth, inner = depth + 1, inner[0]
    if not 2 <= depth <= _POLYGONS and value != []:
        raise ValueError("is not a list of corners [x, y] in metres, of such rings (then holes), or polygons of rings")
    for _ in range(_POLYGONS - depth if value else 0):
        value = [value]
    return _tuples(value)


def _ends(value: object) -> object:
    is_centre = isinstance(value, list) and len(value) == 2 and not isinstance(value[0], list)
    return _tuples([value] if is_centre else value)


_POLYGONS = 4
_Areas: TypeAlias = Annotated[tuple[Rings, ...], BeforeValidator(_areas)]
_Ends: TypeAlias = Annotated[tuple[Point, ...], BeforeValidator(_ends), Field(max_length=2)]
_Metres: TypeAlias = Annotated[float, Field(ge=0, le=10_000, allow_inf_nan=False)]


class RoomSettings(BaseModel):
    """The table ``[places.rooms.NAME]``.

    Attributes:
        floor: The floor of the room.
        doors: The rooms to which a door connects it; it is enough to state a door at one end.
        polygon: Its corners ``[x, y]`` in metres; with holes a list of rings; for several areas a list of these.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    floor: _OptionalName = ""
    doors: _Names = ()
    polygon: _Areas = ()


class HouseDoorSettings(BaseModel):
    """A table ``[[places.doors]]``.

    Attributes:
        name: Its name; by default the names of its rooms.
        rooms: The two rooms; one may be ``outside``.
        position: Its two ends ``[[x, y], [x, y]]`` in metres, or its centre ``[x, y]``; for stairs between two floors,
        their beginning in the first room and end in the second.
        width: The width of a door with a centre, in metres.
        contact: The device that reports whether it is open, by id or name.
        lock: The device that locks it, by id or name.
        cost: The cost of going through it, in metres; by default 10 between two floors.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    name: _OptionalName = ""
    rooms: tuple[_Name, _Name]
    position: _Ends = ()
    width: Annotated[float, Field(gt=0, le=100, allow_inf_nan=False)] = WIDTH
    contact: _OptionalName = ""
    lock: _OptionalName = ""
    cost: _Metres | None = None


class DeviceSettings(BaseModel):
    """The table ``[places.devices.ID]``.

    Attributes:
        room: The room of the device; if rooms are listed, one of them or a floor.
        at: Its position ``X,Y[,FLOOR][ ±ERROR m]`` in metres, by default ±0.1 m.
        aliases: Further names of the device; the first one is shown.
        tags: Words by which it is found.
        identifiers: Hardware addresses, as printed by ``homebot show``. The device is then recognised by any of them
        instead of its id, which may differ in another homebot.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    room: _OptionalName = ""
    at: str = ""
    aliases: _Names = ()
    tags: _Names = ()
    identifiers: Annotated[tuple[str, ...], Field(max_length=_MAX_NAMES)] = ()


class PlacesSettings(BaseModel):
    """The table ``[places]``.

    Attributes:
        rooms: The rooms by name.
        doors: The doors with further facts.
        closed_door: The cost of going through a closed door, in metres.
        devices: The owner's statements, by device id or hardware address.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    rooms: dict[str, RoomSettings] = Field(default_factory=dict)
    doors: Annotated[tuple[HouseDoorSettings, ...], Field(max_length=4000)] = ()
    closed_door: _Metres = CLOSED_DOOR
    devices: dict[str, DeviceSettings] = Field(default_factory=dict)


def read_places(
    table: Mapping[str, object],
    home: str,
    source: str,
    stated_by: str,
    now: float = 0.0,
    known: Iterable[HouseRoom] = (),
) -> Places:
    """Return the validated table ``[places]``.

    Args:
        source: The file, for messages.
        known: Further rooms of the house, to which doors may lead.

    Raises:
        ConfigError: A key is unknown or a value invalid; names *source*, the key, and the value.
    """
    settings = parse_settings(PlacesSettings, table, source, "places")
    rooms = _rooms(settings.rooms, source)
    house_doors = _doors(settings.doors, source)
    plan = HousePlan(home, (*known, *rooms) if rooms or house_doors else (), source, house_doors)
    if plan.has_areas:
        FloorPlan.of(plan)
    devices: dict[tuple[str, ...], tuple[OwnerFact, ...]] = {}
    names: dict[str, str] = {}
    for name, device in settings.devices.items():
        key = f"places.devices.{name}"
        if not name.strip():
            raise ConfigError(source, key, "is not a device: the id is empty")
        known_by = device.identifiers or (name,)
        for known_name in known_by:
            first = names.setdefault(known_name, name)
            if first != name:
                raise ConfigError(source, key, f"{known_name!r} is the device {first!r} already")
        stated = _stated(device, plan, source, key)
        devices[known_by] = tuple(OwnerFact(kind, value, stated_by, now) for kind, value in stated)
    return Places(rooms, devices, house_doors, settings.closed_door)


def _stated(device: DeviceSettings, plan: HousePlan, source: str, key: str) -> Iterator[tuple[FactName, str]]:
    if device.room:
        yield "area", _room(device.room, plan, source, f"{key}.room")
    if device.at:
        try:
            yield "position", stated_position(device.at, plan)
        except UsageError as exc:
            raise ConfigError(source, f"{key}.at", str(exc)) from exc
    yield from (("name", name) for name in _distinct(device.aliases))
    yield from (("tag", tag) for tag in _distinct(device.tags))


def stated_position(text: str, plan: HousePlan) -> str:
    """Return the position *text* with the floor in the plan's spelling; a single floor with areas may be omitted."""
    position = read_position(text)
    floors = {fold(floor): floor for floor in plan.floors}
    if position.floor and floors and fold(position.floor) not in floors:
        raise UsageError(no_such("floor", position.floor, plan.floors))
    only = {room.floor for room in plan.rooms if room.polygons}
    floor = position.floor or (only.pop() if len(only) == 1 else "")  # a floor added later does not change it
    return position._replace(floor=floors.get(fold(floor), floor)).text


def _room(name: str, plan: HousePlan, source: str, key: str) -> str:
    """Return the room called *name*; if rooms are configured, it must be one of them or outside."""
    room, _ = plan.locate(name)
    if room and plan.rooms and plan.room(room) is None and fold(room) != OUTSIDE:
        known = [room.name for room in plan.rooms]
        raise ConfigError(source, key, no_such("room", room, known))
    return room


def _rooms(tables: Mapping[str, RoomSettings], source: str) -> tuple[HouseRoom, ...]:
    spellings: dict[str, str] = {}
    house_rooms: list[HouseRoom] = []
    for name, room in tables.items():
        try:
            spelled = check_name(name)
        except UsageError as exc:
            raise ConfigError(source, f"places.rooms.{name}", str(exc)) from exc
        first = spellings.setdefault(fold(spelled), spelled)
        if first != spelled:
            raise ConfigError(source, f"places.rooms.{name}", f"is the same room as {first!r}")
        house_rooms.append(HouseRoom(spelled, room.floor, room.doors, room.polygon))
    return tuple(house_rooms)


def _doors(tables: Iterable[HouseDoorSettings], source: str) -> tuple[HouseDoor, ...]:
    house_doors: dict[str, HouseDoor] = {}
    for index, door in enumerate(tables):
        name = door.name or door_name(door.rooms)
        if fold(name) in house_doors and door.name:
            raise ConfigError(
                source, f"places.doors.{index}.name", f"is the same door as {house_doors[fold(name)].name!r}"
            )
        if fold(name) in house_doors:
            name = f"{name} {index + 1}"
        house_doors[fold(name)] = HouseDoor(
            name, door.rooms, door.position, door.width, door.contact, door.lock, door.cost
        )
    return tuple(house_doors.values())


def _distinct(values: Iterable[str]) -> tuple[str, ...]:
    """Return *values* without those that only differ in case and accents."""
    spellings: dict[str, str] = {}
    for value in values:
        spellings.setdefault(fold(value), value)
    return tuple(spellings.values())
