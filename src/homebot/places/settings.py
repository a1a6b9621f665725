"""The table ``[places]``, of the configuration and of a places file. Pure."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Field

from homebot.config import parse_settings, value_errors
from homebot.errors import ConfigError, UsageError
from homebot.places.facts import FactName, OwnerFact, Places
from homebot.places.plan import OUTSIDE, HousePlan, HouseRoom
from homebot.support.folding import fold
from homebot.support.similar import did_you_mean

__all__ = ["DeviceSettings", "PlacesSettings", "RoomSettings", "check_name", "read_places"]

_LONGEST = 100
_MOST = 50
"""Doors of a room, and aliases, tags or identifiers of a device."""


def check_name(text: str) -> str:
    """Return *text*, which names a room, a device or a tag, without the blanks around it.

    Raises:
        UsageError: It is empty, longer than 100 characters, or holds a character that cannot be printed.
    """
    name = text.strip()
    if not name:
        raise UsageError("a name is empty")
    if len(name) > _LONGEST:
        raise UsageError(f"a name has {len(name):,} characters; {_LONGEST} is the limit")
    if not name.isprintable():
        raise UsageError(f"{name!r} has a character that cannot be printed")
    if not fold(name):
        raise UsageError(f"{name!r} has no letter and no digit")
    return name


def _name(text: str) -> str:
    with value_errors():
        return check_name(text)


def _name_or_none(text: str) -> str:
    return _name(text) if text else ""


_Name: TypeAlias = Annotated[str, AfterValidator(_name)]
_Names: TypeAlias = Annotated[tuple[_Name, ...], Field(max_length=_MOST)]
_OptionalName: TypeAlias = Annotated[str, AfterValidator(_name_or_none)]


class RoomSettings(BaseModel):
    """The table ``[places.rooms.NAME]``.

    Attributes:
        floor: The floor that the room is on.
        doors: The rooms that a door joins it to; it is enough to name a door at one of its ends.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    floor: _OptionalName = ""
    doors: _Names = ()


class DeviceSettings(BaseModel):
    """The table ``[places.devices.ID]``.

    Attributes:
        room: The room that the device is in.
        aliases: Further names of the device; the first is the one that is shown.
        tags: Words by which it is found.
        identifiers: Hardware addresses, as ``homebot show`` prints them. With these the device is known by any of them
            and not by its id, which may be another one in another homebot.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    room: _OptionalName = ""
    aliases: _Names = ()
    tags: _Names = ()
    identifiers: Annotated[tuple[str, ...], Field(max_length=_MOST)] = ()


class PlacesSettings(BaseModel):
    """The table ``[places]``.

    Attributes:
        rooms: The rooms by name.
        devices: The owner's statements, by device id or hardware address.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    rooms: dict[str, RoomSettings] = Field(default_factory=dict)
    devices: dict[str, DeviceSettings] = Field(default_factory=dict)


def read_places(table: Mapping[str, object], home: str, source: str, stated_by: str, now: float = 0.0) -> Places:
    """Return the table ``[places]``, checked.

    Args:
        table: The table.
        home: The name of the home.
        source: The file, for messages.
        stated_by: See :attr:`OwnerFact.source`.
        now: See :attr:`OwnerFact.said_at`.

    Raises:
        ConfigError: A key is unknown or a value invalid; names *source*, the key, and the value.
    """
    settings = parse_settings(PlacesSettings, table, source, "places")
    rooms = _rooms(settings.rooms, source)
    plan = HousePlan(home, rooms, source)
    devices: dict[tuple[str, ...], tuple[OwnerFact, ...]] = {}
    names: dict[str, str] = {}
    for name, device in settings.devices.items():
        key = f"places.devices.{name}"
        if not name.strip():
            raise ConfigError(source, key, "is no device: the id is empty")
        room = _room(device.room, plan, source, f"{key}.room") if device.room else ""
        stated: list[tuple[FactName, Iterable[str]]] = [
            ("area", (room,) if room else ()),
            ("name", device.aliases),
            ("tag", device.tags),
        ]
        known_by = device.identifiers or (name,)
        for one in known_by:
            first = names.setdefault(one, name)
            if first != name:
                raise ConfigError(source, key, f"{one!r} is the device {first!r} already")
        devices[known_by] = tuple(
            OwnerFact(kind, value, stated_by, now) for kind, values in stated for value in _distinct(values)
        )
    return Places(rooms, devices)


def _room(name: str, plan: HousePlan, source: str, key: str) -> str:
    """Return the room that *name* means; if rooms are configured, it is one of them or outside."""
    room, _ = plan.locate(name)
    if room and plan.rooms and plan.room(room) is None and fold(room) != OUTSIDE:
        known = [one.name for one in plan.rooms]
        hint = did_you_mean(room, known, f"rooms are {', '.join(known)}")
        raise ConfigError(source, key, f"there is no room {room!r}; {hint}")
    return room


def _rooms(tables: Mapping[str, RoomSettings], source: str) -> tuple[HouseRoom, ...]:
    spellings: dict[str, str] = {}
    found: list[HouseRoom] = []
    for name, room in tables.items():
        try:
            spelled = check_name(name)
        except UsageError as exc:
            raise ConfigError(source, f"places.rooms.{name}", str(exc)) from exc
        first = spellings.setdefault(fold(spelled), spelled)
        if first != spelled:
            raise ConfigError(source, f"places.rooms.{name}", f"is the same room as {first!r}")
        found.append(HouseRoom(spelled, room.floor, room.doors))
    return tuple(found)


def _distinct(values: Iterable[str]) -> tuple[str, ...]:
    """Return *values* without those that differ in case and accents alone."""
    found: dict[str, str] = {}
    for value in values:
        found.setdefault(fold(value), value)
    return tuple(found.values())
